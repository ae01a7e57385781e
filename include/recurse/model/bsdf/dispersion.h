/** @file
 * Spectral sampling within RGB transport: from the first dispersive refraction on, a path has one wavelength,
 * with an RGB weight. Wilkie et al. 2014 draw it at the start of a path; here reflections before that
 * refraction stay white, so that one sample has all wavelengths (doc-files/notes/dispersion.md).
 */
#pragma once

#include <array>
#include <vector>

#include "recurse/core/math/rgb.h"
#include "recurse/scene/parameters/spectrum.h"

namespace recurse {

/** Samples a wavelength [nm] from u in [0, 1), with a density in proportion to its colour's magnitude. */
float sampleWavelength(float u);
/** RGB weight of a sampled wavelength [nm]: its colour over its density. Its mean over samples is (1, 1, 1);
 * components may be negative. */
Rgb wavelengthColour(float wavelength);

/** Refractive index as a function of wavelength [nm]. */
class DispersiveIndex {
 public:
  /** `index` must not be empty. */
  explicit DispersiveIndex(const SampledSpectrum& index);
  bool isConstant() const { return constant; }
  float at(float wavelength) const { return static_cast<float>(spectrum.at(double(wavelength))); }

  /** One of the wavelengths that represent white light. */
  struct Part {
    float index; ///< refractive index
    Rgb colour;  ///< RGB weight
  };
  static constexpr size_t PARTS = 8;
  /** White light, at the midpoints of PARTS intervals of equal probability; the weights sum to (1, 1, 1). */
  const std::array<Part, PARTS>& parts() const { return whiteParts; }

 private:
  SampledSpectrum spectrum;
  std::array<Part, PARTS> whiteParts;
  bool constant = false;
};

/** Refractive index, every 5 nm from 360 to 780 nm, by Cauchy's formula n = A + B/λ² for index n_d at 587.56
 * nm and Abbe number (n_d - 1) / (n_F - n_C), F: 486.13 nm, C: 656.27 nm. */
SampledSpectrum cauchyIndex(double indexD, double abbe);

} // namespace recurse
