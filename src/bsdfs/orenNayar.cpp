/** @file
 * Rough diffuse surfaces: Oren and Nayar 1994, "Generalization of Lambert's Reflectance Model", in the form
 * of Portsmouth, Kutz and Hill 2024 ("EON: A Practical Energy-Preserving Rough Diffuse BRDF"). Its single
 * scattering is Fujii's; multiple scattering compensates the energy that this loses.
 */
#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class OrenNayarBsdf final : public Bsdf {
 public:
  OrenNayarBsdf(const Rgb& reflectance, float roughness) : reflectance(reflectance) {
    a = 1 / (1 + (0.5f - 2 * INV_PI / 3) * roughness);
    b = a * roughness;
    const float mean = a + b * (2.0f / 3 - 28 * INV_PI / 15);
    missing = 1 - mean;
    multiple = reflectance * reflectance * mean / (1.0f - reflectance * missing);
  }
  LobeSet lobes() const override { return REFLECTION; }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    if (!(wi.z * wo.z > 0)) return BLACK;
    const float ci = std::abs(wi.z), co = std::abs(wo.z);
    const float s = wi.x * wo.x + wi.y * wo.y;
    const float single = a + b * (s > 0 ? s / std::max(ci, co) : s);
    const float lost = missing > 1e-6f ? (1 - single1(ci)) * (1 - single1(co)) / missing : 0;
    return (reflectance * std::max(single, 0.0f) + multiple * std::max(lost, 0.0f)) * INV_PI;
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    return wi.z * wo.z > 0 ? std::abs(wo.z) * INV_PI : 0;
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float) const override {
    const Vec3f wo = cosineHemisphere(u);
    return Vec3f(wo.x, wo.y, std::copysign(wo.z, wi.z));
  }
  Rgb albedo(const Vec3f& wi) const override {
    const float e = std::min(single1(std::abs(wi.z)), 1.0f);
    const float lost = missing > 1e-6f ? 1 - e : 0;
    return min(reflectance * e + multiple * lost, Rgb(1));
  }
  bool lossless() const override { return reflectance == Rgb(1); }

 private:
  /** Albedo of single scattering with reflectance 1 (EON, equation 18). */
  float single1(float cosine) const {
    const float sine = std::sqrt(std::max(0.0f, 1 - square(cosine)));
    const float theta = std::atan2(sine, cosine);
    // tan (1 - sin³) without the quotient of zeros at grazing: 1 - sin³ = cos² (1 + sin + sin²) / (1 + sin).
    const float last = sine * cosine * (1 + sine + square(sine)) / (1 + sine);
    return a + b * INV_PI * (sine * (theta - sine * cosine) + 2.0f / 3 * (last - sine));
  }

  Rgb reflectance, multiple;
  float a, b, missing;
};

class OrenNayar final : public Material {
 public:
  OrenNayar(const TexturedRgb& reflectance, const TexturedRgb& sigma)
      : reflectance(reflectance), sigma(sigma) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    // The ratio of Oren and Nayar's own two terms (their equation 30) at this deviation of the slopes.
    const float s2 = square(glm::radians(sigma.at(point).r));
    const float ratio = 0.45f * s2 / (s2 + 0.09f) / (1 - 0.5f * s2 / (s2 + 0.33f));
    return arena.make<OrenNayarBsdf>(reflectance.at(point), ratio);
  }
  LobeSet lobes() const override { return REFLECTION; }

 private:
  TexturedRgb reflectance, sigma;
};

} // namespace

void registerOrenNayar(PlugIns& plugIns) {
  plugIns.materials.add(
      {{.name = "orennayar",
        .summary = "Oren-Nayar's rough diffuse surface, such as clay or the Moon: shading is flatter than "
                   "Lambert's law; conserves energy.",
        .parameters = {spectrumParameter("reflectance", "0.5", SpectrumKind::ALBEDO, "albedo of the facets")
                           .withTexture(),
                       realParameter("sigma", "20",
                                     "standard deviation of the slope angle of the facets [degrees]")
                           .range(0, 90)
                           .withTexture()},
        .examples = {"", "\"rgb reflectance\" [1 1 1] \"float sigma\" 35",
                     "\"rgb reflectance\" [.9 .5 .2] \"float sigma\" 90"}},
       [](const Parameters& p, const MaterialContext& c) {
         return std::make_unique<OrenNayar>(c.textures.rgb(p, "reflectance"), c.textures.real(p, "sigma"));
       }});
}

} // namespace recurse
