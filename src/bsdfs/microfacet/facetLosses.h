/** @file
 * Energy lost by microfacet models with single scattering, and its compensation by a lobe that has the shape
 * of the loss in each direction (Kelemen and Szirmay-Kalos 2001, "A Microfacet Based Coupled Specular-Matte
 * BRDF Model"; Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks"). The lobe is
 * reciprocal, and passes the white furnace test.
 */
#pragma once

#include "bsdfs/microfacet/albedoTable.h"
#include "bsdfs/microfacet/roughness.h"

namespace recurse {

/** Energy losses at all points of a material. */
class FacetLosses {
 public:
  FacetLosses() = default;
  /** `albedo(wi, facets, u)` is the weight of one sample of the single scattering, for wi.z > 0.
   * Anisotropic roughness must not be textured. */
  template <class F> FacetLosses(const Roughness& roughness, const F& albedo) {
    if (roughness.textured()) {
      over = Over::ROUGHNESS;
      table = AlbedoTable(Microfacets::SMOOTH_BELOW, MAX_ROUGH,
                          [&](const Vec3f& wi, float alpha, const Vec2f& u) {
                            return albedo(wi, Microfacets(roughness.kind, Vec2f(alpha)), u);
                          });
      return;
    }
    const Microfacets facets = roughness.at({});
    if (facets.smooth()) return;
    over = facets.anisotropic() ? Over::AZIMUTH : Over::NOTHING;
    table = AlbedoTable(
        0, over == Over::AZIMUTH ? 1.0f : 0.0f,
        [&](const Vec3f& wi, float sine2, const Vec2f& u) {
          const Vec3f turned(wi.x * std::sqrt(1 - sine2), wi.x * std::sqrt(sine2), wi.z);
          return albedo(turned, facets, u);
        },
        8);
    if (over != Over::AZIMUTH) return;
    constexpr int N = 64;
    for (int i = 0; i < N; ++i)
      meanOverAzimuth += table.mean(square(std::sin((static_cast<float>(i) + 0.5f) * PI / (2 * N)))) / N;
  }

  bool empty() const { return table.empty(); }
  /** Fraction of the light from w, on either side, that single scattering loses. */
  float lost(const Vec3f& w, const Microfacets& facets) const {
    float row = 0;
    if (over == Over::ROUGHNESS) row = facets.meanRoughness();
    if (over == Over::AZIMUTH) {
      const float across2 = square(w.x) + square(w.y);
      row = across2 > 0 ? square(w.y) / across2 : 0;
    }
    return std::max(1 - table.at(std::abs(w.z), row), MIN_COUNT);
  }
  /** Cosine-weighted mean of lost() over all directions. */
  float meanLost(const Microfacets& facets) const {
    const float mean = over == Over::AZIMUTH ? meanOverAzimuth : table.mean(facets.meanRoughness());
    return std::max(1 - mean, MIN_COUNT);
  }

 private:
  enum class Over { NOTHING, ROUGHNESS, AZIMUTH }; ///< parameter of the table's rows, besides the cosine
  static constexpr float MAX_ROUGH = 3.2f;         ///< square root of the largest accepted roughness
  static constexpr float MIN_COUNT =
      1e-6f; ///< least loss, so that quotients stay meaningful where almost nothing is lost

  Over over = Over::NOTHING;
  AlbedoTable table;
  float meanOverAzimuth = 0;
};

/** Declares `multiscatter`. */
inline void addMultipleScatteringParameter(std::vector<ParameterSpec>& parameters) {
  parameters.push_back(
      booleanParameter("multiscatter", "false",
                       "multiple scattering between facets: adds the energy that single scattering loses, up "
                       "to a third on very rough surfaces; pbrt-v4 does not"));
}
/** True where `multiscatter` is requested. Throws SceneError for a roughness that it does not support. */
inline bool wantsMultipleScattering(const Parameters& p, const Roughness& roughness) {
  if (!p.boolean("multiscatter")) return false;
  if (roughness.textured() && roughness.anisotropic())
    p.fail("multiscatter", "multiple scattering is not supported for anisotropic roughness from textures",
           "one texture, or numbers, for the roughness");
  return true;
}

} // namespace recurse
