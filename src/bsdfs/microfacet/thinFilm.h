/** @file
 * Thin film on an interface: interference of the light that its two faces reflect.
 */
#pragma once

#include <complex>

#include "recurse/model/texture/texture.h"

namespace recurse {

/** Film of a dielectric on a surface, in air. */
struct ThinFilm {
  float thickness = 0; ///< [nm]; 0: none
  float eta = 1.33f;   ///< refractive index over that of the outside, at least 1

  bool exists() const { return thickness > 0; }
  /** Reflectance for unpolarised daylight on a base of index eta + i k for each colour channel. `cosOutside`:
   * cosine of the ray outside of the film with the normal, in [0, 1]. */
  Rgb reflectance(float cosOutside, const Rgb& baseEta, const Rgb& baseK = Rgb(0)) const;
};

/** Declares `thinfilm.thickness` and `thinfilm.eta`. */
void addThinFilmParameters(std::vector<ParameterSpec>& parameters);

/** Film that the parameters describe. */
class ThinFilmParameters {
 public:
  ThinFilmParameters(const Parameters& p, const TextureLookup& textures);
  /** Whether there is a film anywhere. */
  bool exists() const { return thickness.texture || thickness.constant.r > 0; }
  bool textured() const { return thickness.texture || eta.texture; }
  ThinFilm at(const SurfacePoint& point) const {
    return {std::max(thickness.at(point).r, 0.0f), eta.at(point).r};
  }

 private:
  TexturedRgb thickness, eta;
};

} // namespace recurse
