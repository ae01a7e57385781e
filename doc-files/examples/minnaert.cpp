/** @file
 * Minnaert reflection: the cosine law with an exponent (Minnaert 1941, "The Reciprocity Principle in Lunar
 * Photometry").
 */
#include <cmath>

#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** At one point, in the frame of the surface: z is the normal. */
class MinnaertBsdf final : public Bsdf {
 public:
  MinnaertBsdf(const Rgb& colour, float k) : colour(colour), k(k) {}
  LobeSet lobes() const override { return REFLECTION; }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    return wi.z * wo.z > 0 ? colour * (std::pow(wi.z * wo.z, k - 1) * (k + 1) * 0.5f * INV_PI) : BLACK;
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    return wi.z * wo.z > 0 ? std::abs(wo.z) * INV_PI : 0;
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float) const override {
    const Vec3f wo = cosineHemisphere(u);
    return Vec3f(wo.x, wo.y, std::copysign(wo.z, wi.z));
  }
  Rgb albedo(const Vec3f& wi) const override { return colour * std::pow(std::abs(wi.z), k - 1); }

 private:
  Rgb colour;
  float k;
};

class Minnaert final : public Material {
 public:
  Minnaert(const TexturedRgb& colour, float k) : colour(colour), k(k) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    return arena.make<MinnaertBsdf>(colour.at(point), k);
  }
  LobeSet lobes() const override { return REFLECTION; }

 private:
  TexturedRgb colour;
  float k;
};

} // namespace

void registerMinnaert(PlugIns& plugIns) {
  plugIns.materials.add(
      {{.name = "minnaert",
        .summary = "Minnaert reflection, darker towards the limb.",
        .parameters =
            {spectrumParameter("colour", "0.5", SpectrumKind::ALBEDO, "albedo seen from above").withTexture(),
             realParameter("k", "1.5", "exponent; 1 is Lambert's law").range(1, 10)},
        .examples = {"\"rgb colour\" [.8 .8 .7] \"float k\" 2"}},
       [](const Parameters& p, const MaterialContext& c) {
         return std::make_unique<Minnaert>(c.textures.rgb(p, "colour"), static_cast<float>(p.real("k")));
       }});
}

} // namespace recurse
