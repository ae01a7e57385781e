/** @file
 * Optical constants of metals, and the material parameters that specify them.
 */
#pragma once

#include <vector>

#include "bsdfs/microfacet/fresnel.h"
#include "bsdfs/microfacet/thinFilm.h"
#include "recurse/model/texture/texture.h"

namespace recurse {

/** Complex refractive index eta + i k of each colour channel. */
struct ConductorOptics {
  Rgb eta{1}, k{0};
  ThinFilm film{}; ///< on the metal
  /** Fresnel reflectance; `cosine` with the (micro)surface normal, in [0, 1]; rounding above 1 is clamped. */
  Rgb reflectance(float cosine) const {
    const float c = std::min(cosine, 1.0f);
    if (film.exists()) return film.reflectance(c, eta, k);
    return {conductorFresnel(c, eta.r, k.r), conductorFresnel(c, eta.g, k.g),
            conductorFresnel(c, eta.b, k.b)};
  }
  /** Reflectance for uniform diffuse light: 2 ∫ R(μ) μ dμ by five-point Gauss quadrature. */
  Rgb meanReflectance() const {
    Rgb sum(0);
    constexpr float X[] = {0.0469101f, 0.2307653f, 0.5f, 0.7692347f, 0.9530899f},
                    W[] = {0.1184634f, 0.2393143f, 0.2844444f, 0.2393143f, 0.1184634f};
    for (int i = 0; i < 5; ++i) sum += reflectance(X[i]) * (2 * W[i] * X[i]);
    return sum;
  }
};

/** Declares `eta`, `k` and `reflectance`; coatings put `prefix` before the first two. */
inline void addConductorParameters(std::vector<ParameterSpec>& parameters, const std::string& prefix = "") {
  parameters.push_back(spectrumParameter(prefix + "eta", "", SpectrumKind::UNBOUNDED,
                                         "refractive index of the metal; by default metal-Cu-eta")
                           .withTexture());
  parameters.push_back(spectrumParameter(prefix + "k", "", SpectrumKind::UNBOUNDED,
                                         "absorption coefficient; by default metal-Cu-k")
                           .withTexture());
  parameters.push_back(
      spectrumParameter("reflectance", "", SpectrumKind::ALBEDO,
                        "reflectance at normal incidence instead of eta and k: sets eta = 1 and k = 2 "
                        "sqrt(r) / sqrt(1 - r), so that the reflectance grows to 1 at grazing incidence")
          .withTexture());
}

/** Metal that the parameters describe. */
class ConductorParameters {
 public:
  ConductorParameters(const Parameters& p, const TextureLookup& textures, const std::string& prefix = "") {
    fromReflectance = p.has("reflectance");
    if (fromReflectance) {
      for (const char* other : {"eta", "k"})
        if (p.has(prefix + other))
          p.fail(prefix + other, "both \"reflectance\" and \"" + prefix + other + "\" are given",
                 "one of them");
      reflectance = textures.rgb(p, "reflectance");
      return;
    }
    // Copper at 611, 549 and 464 nm (P. B. Johnson and R. W. Christy 1972), pbrt's default metal.
    eta.constant = {0.2004f, 0.9240f, 1.1022f};
    k.constant = {3.9129f, 2.4528f, 2.1421f};
    if (p.has(prefix + "eta")) eta = textures.rgb(p, prefix + "eta");
    if (p.has(prefix + "k")) k = textures.rgb(p, prefix + "k");
  }

  bool textured() const { return eta.texture || k.texture || reflectance.texture; }
  ConductorOptics at(const SurfacePoint& point) const {
    if (!fromReflectance) return {eta.at(point), k.at(point), {}};
    // pbrt's meaning of `reflectance`: the conductor with eta 1 that has this reflectance at normal
    // incidence. A reflectance of 1 would need an infinite k; 0.9999 is pbrt's limit.
    const Rgb r = clamp(reflectance.at(point), 0.0f, 0.9999f);
    return {Rgb(1), 2.0f * sqrt(r) / sqrt(1 - r), {}};
  }

 private:
  TexturedRgb eta, k, reflectance;
  bool fromReflectance = false;
};

} // namespace recurse
