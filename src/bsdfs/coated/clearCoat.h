/** @file
 * What a clear coat lets through and sends back, tabulated.
 */
#pragma once

#include <memory>
#include <vector>

#include "bsdfs/microfacet/albedoTable.h"
#include "bsdfs/microfacet/dielectricInterface.h"

namespace recurse {

/** Of light that crosses a coat with extinction 1; `distance` is the coat's thickness. */
inline float slabTransmittance(float distance, float cosine) {
  return std::exp(-std::abs(distance / cosine));
}

/** What a clear coat does with light between its outside and a diffuse base. */
class ClearCoat {
 public:
  ClearCoat(float eta, MicrofacetKind kind, float minAlpha, float maxAlpha, float thickness);

  /** Of light from outside, what comes to the base. */
  float transmittance(const DielectricInterface& coat, float cosine) const;
  /** Of light that the base scatters, what comes back to it. */
  float reflectance(const DielectricInterface& coat) const;

  /** Coats that are alike share what is tabulated. */
  static std::shared_ptr<const ClearCoat> make(float eta, MicrofacetKind kind, float minAlpha, float maxAlpha,
                                               float thickness);

 private:
  float meanReflectance(const DielectricInterface& coat) const;

  float thickness, minAlpha, maxAlpha;
  AlbedoTable transmitted;
  std::vector<float> returned; ///< over equal steps of alpha
};

} // namespace recurse
