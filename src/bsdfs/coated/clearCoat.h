/** @file
 * Transmittance and internal reflectance of a clear coat, tabulated.
 */
#pragma once

#include <memory>
#include <vector>

#include "bsdfs/microfacet/albedoTable.h"
#include "bsdfs/microfacet/dielectricInterface.h"

namespace recurse {

/** Transmittance of a coat with extinction 1; `distance` is its thickness. */
inline float slabTransmittance(float distance, float cosine) {
  return std::exp(-std::abs(distance / cosine));
}

/** Transport of light through a clear coat, between its outside and a diffuse base. */
class ClearCoat {
 public:
  ClearCoat(float eta, MicrofacetKind kind, float minAlpha, float maxAlpha, float thickness);

  /** Fraction of the light from outside that reaches the base. */
  float transmittance(const DielectricInterface& coat, float cosine) const;
  /** Fraction of the light scattered by the base that the coat returns to it. */
  float reflectance(const DielectricInterface& coat) const;

  /** Coat whose tables are shared by all coats of equal parameters. */
  static std::shared_ptr<const ClearCoat> make(float eta, MicrofacetKind kind, float minAlpha, float maxAlpha,
                                               float thickness);

 private:
  float meanReflectance(const DielectricInterface& coat) const;

  float thickness, minAlpha, maxAlpha;
  AlbedoTable transmitted;
  std::vector<float> returned; ///< reflectance towards the base, at equal steps of alpha
};

} // namespace recurse
