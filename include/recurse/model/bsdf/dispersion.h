/** @file
 * Light of one wavelength among colours: from the first dispersive refraction on a path has a wavelength, and
 * the colour that white light takes on by it (Wilkie et al. 2014 draw it before; what is mirrored before that
 * refraction stays white here, so that all wavelengths are in one sample; doc-files/notes/dispersion.md).
 */
#pragma once

#include <array>
#include <vector>

#include "recurse/core/math/rgb.h"
#include "recurse/scene/parameters/spectrum.h"

namespace recurse {

/** A wavelength [nm] for u in [0, 1), with a density in proportion to its colour's strength. */
float sampleWavelength(float u);
/** What light of a sampled wavelength is to be multiplied by: its colour over the density. In the mean over
 * samples exactly (1, 1, 1); components may be below zero. */
Rgb wavelengthColour(float wavelength);

/** A refractive index by wavelength. */
class DispersiveIndex {
 public:
  /** `index`: not empty. */
  explicit DispersiveIndex(const SampledSpectrum& index);
  bool isConstant() const { return constant; }
  float at(float wavelength) const { return static_cast<float>(spectrum.at(double(wavelength))); }

  /** Wavelengths that stand for white light, with the colours of their parts, whose sum is (1, 1, 1). */
  struct Part {
    float index;
    Rgb colour;
  };
  static constexpr size_t PARTS = 8;
  const std::array<Part, PARTS>& parts() const { return whiteParts; }

 private:
  SampledSpectrum spectrum;
  std::array<Part, PARTS> whiteParts;
  bool constant = false;
};

/** The index by Cauchy's formula n = A + B/λ² of a glass with this index n_d at 587.56 nm and this Abbe
 * number (n_d - 1) / (n_F - n_C). */
SampledSpectrum cauchyIndex(double indexD, double abbe);

} // namespace recurse
