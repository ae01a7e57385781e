/** @file
 * Roughness parameters that several materials share, with the meaning of pbrt-v4.
 */
#pragma once

#include <vector>

#include "bsdfs/microfacet/microfacet.h"
#include "recurse/model/texture/texture.h"

namespace recurse {

/**
 * Declares `roughness`, `uroughness` and `vroughness` (after `prefix`, which coatings have), `remaproughness`
 * and `distribution`.
 */
inline void addRoughnessParameters(std::vector<ParameterSpec>& parameters, const std::string& prefix = "",
                                   const std::string& roughness = "0") {
  const char* smooth = "microfacet roughness; if alpha is below 0.001, the surface is perfectly smooth and S "
                       "in path classes, else D";
  parameters.push_back(realParameter(prefix + "roughness", roughness, smooth).range(0, 10).withTexture());
  for (const char* axis : {"u", "v"})
    parameters.push_back(realParameter(prefix + axis + "roughness", "",
                                       std::string("roughness along ") + axis + " alone, instead")
                             .range(0, 10)
                             .withTexture());
  for (const ParameterSpec& p : parameters)
    if (p.name == "remaproughness") return;
  parameters.push_back(booleanParameter(
      "remaproughness", "true",
      "alpha is the square root of the roughness, as in pbrt-v4; false: alpha is the roughness"));
  parameters.push_back(stringParameter("distribution", "trowbridgereitz",
                                       "microfacet distribution: Trowbridge-Reitz (GGX) or Beckmann")
                           .oneOf({"trowbridgereitz", "beckmann"}));
}

/** Microfacets of a material. */
struct Roughness {
  TexturedRgb u, v;
  bool remap = true;
  MicrofacetKind kind = MicrofacetKind::TROWBRIDGE_REITZ;

  Roughness() = default;
  Roughness(const Parameters& p, const TextureLookup& textures, const std::string& prefix = "")
      : remap(p.boolean("remaproughness")),
        kind(p.string("distribution") == "beckmann" ? MicrofacetKind::BECKMANN
                                                    : MicrofacetKind::TROWBRIDGE_REITZ) {
    const auto along = [&](const char* axis) {
      const std::string own = prefix + axis + "roughness";
      return textures.real(p, p.has(own) ? own : prefix + "roughness");
    };
    u = along("u");
    v = along("v");
  }

  Microfacets at(const SurfacePoint& point) const {
    const Vec2f alpha(u.at(point).r, v.at(point).r);
    return {kind, remap ? glm::sqrt(alpha) : alpha};
  }
  bool textured() const { return u.texture || v.texture; }
  /** True when no point (or every point) is smooth. */
  bool neverSmooth() const { return !textured() && !constant().smooth(); }
  bool alwaysSmooth() const { return !textured() && constant().smooth(); }
  bool anisotropic() const { return textured() ? u.texture != v.texture : constant().anisotropic(); }

 private:
  Microfacets constant() const { return at(SurfacePoint{}); }
};

} // namespace recurse
