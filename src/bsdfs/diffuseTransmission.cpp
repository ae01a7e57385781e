/** @file
 * Lambertian reflection and transmission: paper, leaves, thin cloth.
 */
#include "recurse/core/io/text.h"
#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class DiffuseTransmissionBsdf final : public Bsdf {
 public:
  DiffuseTransmissionBsdf(const Rgb& reflectance, const Rgb& transmittance)
      : reflectance(reflectance), transmittance(transmittance) {
    const float r = maxComponent(reflectance), t = maxComponent(transmittance);
    reflected = r + t > 0 ? r / (r + t) : 0;
  }
  LobeSet lobes() const override { return NON_DELTA_LOBES; }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    const float product = wi.z * wo.z;
    return product > 0 ? reflectance * INV_PI : product < 0 ? transmittance * INV_PI : BLACK;
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    const float product = wi.z * wo.z;
    if (product == 0 || (isBlack(reflectance) && isBlack(transmittance))) return 0;
    return (product > 0 ? reflected : 1 - reflected) * std::abs(wo.z) * INV_PI;
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    if (isBlack(reflectance) && isBlack(transmittance)) return {};
    Vec3f wo = cosineHemisphere(u);
    if ((wi.z < 0) == (pick < reflected)) wo.z = -wo.z;
    return wo;
  }
  Rgb albedo(const Vec3f&) const override { return min(reflectance + transmittance, Rgb(1)); }
  bool lossless() const override { return reflectance + transmittance == Rgb(1); }

 private:
  Rgb reflectance, transmittance;
  float reflected; ///< probability of sampling reflection
};

class DiffuseTransmission final : public Material {
 public:
  DiffuseTransmission(const TexturedRgb& reflectance, const TexturedRgb& transmittance, float scale)
      : reflectance(reflectance), transmittance(transmittance), scale(scale) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    const Rgb r = reflectance.at(point) * scale, t = transmittance.at(point) * scale;
    const float most = std::max(maxComponent(r + t), 1.0f);
    return arena.make<DiffuseTransmissionBsdf>(r / most, t / most);
  }
  LobeSet lobes() const override { return NON_DELTA_LOBES; }

 private:
  TexturedRgb reflectance, transmittance;
  float scale;
};

} // namespace

void registerDiffuseTransmission(PlugIns& plugIns) {
  plugIns.materials.add({{.name = "diffusetransmission",
                          .summary = "Lambertian reflection and transmission, as of paper.",
                          .parameters = {spectrumParameter("reflectance", "0.25", SpectrumKind::ALBEDO,
                                                           "albedo of the reflected light")
                                             .withTexture(),
                                         spectrumParameter("transmittance", "0.25", SpectrumKind::ALBEDO,
                                                           "albedo of the transmitted light; if both add up "
                                                           "to more than 1, they are scaled to a sum of 1")
                                             .withTexture(),
                                         realParameter("scale", "1", "factor on both albedos").range(0, 1)},
                          .examples = {"", "\"rgb reflectance\" [.5 .2 .1] \"rgb transmittance\" [.5 .7 .3]",
                                       "\"rgb reflectance\" [.25 .5 1] \"rgb transmittance\" [.75 .5 0]"}},
                         [](const Parameters& p, const MaterialContext& c) {
                           const double scale = p.real("scale");
                           if (p.texture("reflectance").empty() && p.texture("transmittance").empty()) {
                             const Rgbd sum =
                                 (p.spectrum("reflectance") + p.spectrum("transmittance")) * scale;
                             const double most = std::max({sum.r, sum.g, sum.b});
                             if (most > 1 + 1e-6)
                               p.warn(p.has("transmittance") ? "transmittance" : "reflectance",
                                      formatted("reflectance and transmittance add up to %.3g: more light "
                                                "would leave than arrives. Both are divided by that sum",
                                                most));
                           }
                           return std::make_unique<DiffuseTransmission>(c.textures.rgb(p, "reflectance"),
                                                                        c.textures.rgb(p, "transmittance"),
                                                                        static_cast<float>(scale));
                         }});
}

} // namespace recurse
