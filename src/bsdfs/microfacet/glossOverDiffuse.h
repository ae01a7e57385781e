/** @file
 * Base of the classic gloss models: a gloss lobe beside, or on top of, a diffuse lobe, equal on both sides of
 * the surface.
 */
#pragma once

#include "recurse/core/sampling/sampling.h"
#include "recurse/model/bsdf/bsdf.h"

namespace recurse {

/** A `Gloss` has, for directions with z >= 0: the reciprocal lobes `value(a, b)` and `diffuse(a, b)`
 * [1/sr]; `sample(a, u, pick)` of the gloss lobe, below the surface where it absorbs, and its density
 * `pdf(a, b)` [1/sr]; approximate `albedo(a)` and `diffuseAlbedo(a)`; `anisotropic()` and `lossless()`. */
template <class Gloss> class GlossOverDiffuse final : public Bsdf {
 public:
  explicit GlossOverDiffuse(const Gloss& gloss) : gloss(gloss) {}

  LobeSet lobes() const override { return gloss.anisotropic() ? REFLECTION | ANISOTROPIC : REFLECTION; }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    if (!(wi.z * wo.z > 0)) return BLACK;
    const Vec3f a = up(wi), b = up(wo);
    return gloss.value(a, b) + gloss.diffuse(a, b);
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    if (!(wi.z * wo.z > 0)) return 0;
    const Vec3f a = up(wi), b = up(wo);
    const float glossy = chance(a);
    return (glossy > 0 ? glossy * gloss.pdf(a, b) : 0) + (1 - glossy) * b.z * INV_PI;
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    const Vec3f a = up(wi);
    const float glossy = chance(a);
    const Vec3f wo =
        pick < glossy ? gloss.sample(a, u, std::min(pick / glossy, ONE_MINUS_EPSILON)) : cosineHemisphere(u);
    if (!(wo.z > 0)) return {};
    const Vec3f unit = glm::normalize(wo);
    return wi.z < 0 ? Vec3f(unit.x, unit.y, -unit.z) : unit;
  }
  Rgb albedo(const Vec3f& wi) const override {
    const Vec3f a = up(wi);
    return min(gloss.albedo(a) + gloss.diffuseAlbedo(a), Rgb(1));
  }
  bool lossless() const override { return gloss.lossless(); }

 private:
  static Vec3f up(const Vec3f& w) { return {w.x, w.y, std::abs(w.z)}; }
  /** Probability of the gloss lobe, clamped so that errors of the approximate albedo cause no fireflies. */
  float chance(const Vec3f& a) const {
    const float g = maxComponent(gloss.albedo(a)), d = maxComponent(gloss.diffuseAlbedo(a));
    if (!(d > 0)) return 1;
    if (!(g > 0)) return 0;
    return std::clamp(g / (g + d), 0.1f, 0.9f);
  }

  Gloss gloss;
};

/** Material that makes GlossOverDiffuse from the result of `make(point)`. */
template <class Make> class GlossMaterial final : public Material {
 public:
  GlossMaterial(const Make& make, bool anisotropic)
      : make(make), lobeSet(anisotropic ? REFLECTION | ANISOTROPIC : REFLECTION) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    const auto gloss = make(point);
    return arena.make<GlossOverDiffuse<std::remove_const_t<decltype(gloss)>>>(gloss);
  }
  LobeSet lobes() const override { return lobeSet; }

 private:
  Make make;
  LobeSet lobeSet;
};
template <class Make> std::unique_ptr<Material> glossMaterial(const Make& make, bool anisotropic) {
  return std::make_unique<GlossMaterial<Make>>(make, anisotropic);
}

/** Declares the two colours that the classic models share. */
inline void addGlossParameters(std::vector<ParameterSpec>& parameters) {
  parameters.push_back(
      spectrumParameter("specular", "0.25", SpectrumKind::ALBEDO, "reflectance of the gloss lobe")
          .withTexture());
  parameters.push_back(spectrumParameter("reflectance", "0.5", SpectrumKind::ALBEDO,
                                         "albedo of the diffuse part; it is multiplied by 1 - specular")
                           .withTexture());
}

} // namespace recurse
