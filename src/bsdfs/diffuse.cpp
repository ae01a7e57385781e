/** @file
 * Lambertian reflection, the same on both sides of the surface.
 */
#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class DiffuseBsdf final : public Bsdf {
 public:
  explicit DiffuseBsdf(const Rgb& reflectance) : reflectance(reflectance) {}
  LobeSet lobes() const override { return REFLECTION | LAMBERTIAN; }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    return wi.z * wo.z > 0 ? reflectance * INV_PI : BLACK;
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    return wi.z * wo.z > 0 ? std::abs(wo.z) * INV_PI : 0;
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float) const override {
    Vec3f wo = cosineHemisphere(u);
    if (wi.z < 0) wo.z = -wo.z;
    return wo;
  }
  Rgb albedo(const Vec3f&) const override { return reflectance; }
  bool lossless() const override { return reflectance == Rgb(1); }

 private:
  Rgb reflectance;
};

class Diffuse final : public Material {
 public:
  explicit Diffuse(const TexturedRgb& reflectance) : reflectance(reflectance) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    return arena.make<DiffuseBsdf>(reflectance.at(point));
  }
  LobeSet lobes() const override { return REFLECTION | LAMBERTIAN; }

 private:
  TexturedRgb reflectance;
};

} // namespace

void registerDiffuse(PlugIns& plugIns) {
  plugIns.materials.add(
      {{.name = "diffuse",
        .summary = "Lambertian reflection, the same on both sides.",
        .parameters = {spectrumParameter("reflectance", "0.5", SpectrumKind::ALBEDO, "albedo").withTexture()},
        .examples = {"\"rgb reflectance\" [.8 .5 .2]", "\"rgb reflectance\" [1 1 1]"}},
       [](const Parameters& p, const MaterialContext& c) {
         return std::make_unique<Diffuse>(c.textures.rgb(p, "reflectance"));
       }});
}

} // namespace recurse
