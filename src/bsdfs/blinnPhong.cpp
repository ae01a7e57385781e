/** @file
 * Blinn and Phong's gloss: Blinn 1977, "Models of Light Reflection for Computer Synthesized Pictures", scaled
 * so that the lobe reflects `specular` at normal incidence and less elsewhere.
 */
#include "bsdfs/microfacet/glossOverDiffuse.h"
#include "bsdfs/microfacet/microfacet.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class BlinnPhongGloss {
 public:
  BlinnPhongGloss(const Rgb& specular, const Rgb& reflectance, float exponent)
      : specular(specular), base(reflectance * (1.0f - specular)), n(exponent) {
    // 1 / ∫ cos^n(θ/2) cos θ dω over the hemisphere, the albedo at normal incidence (Giesen 2009, "Phong and
    // Blinn-Phong Normalization Factors"); the albedo falls from there.
    scale = (n + 2) * (n + 4) / (8 * PI * (std::exp2(-n / 2) + n));
  }
  bool anisotropic() const { return false; }
  bool lossless() const { return false; }
  Rgb value(const Vec3f& a, const Vec3f& b) const { return specular * (scale * power(halfVector(a, b), n)); }
  float pdf(const Vec3f& a, const Vec3f& b) const {
    const Vec3f h = halfVector(a, b);
    const float c = glm::dot(a, h);
    return c > 0 ? (n + 2) / (2 * PI) * power(h, n + 1) / (4 * c) : 0;
  }
  Vec3f sample(const Vec3f& a, const Vec2f& u, float) const {
    // Half vectors with density (n + 2)/(2π) cos^(n+1).
    const float x = std::log1p(-u.x) * 2 / (n + 2); // ln cos²
    const float sine = std::sqrt(-std::expm1(x)), phi = 2 * PI * u.y;
    return mirrored(a, {sine * std::cos(phi), sine * std::sin(phi), std::exp(x / 2)});
  }
  Rgb albedo(const Vec3f& a) const { return specular * std::max(a.z * (2 - a.z), 1 / (1 + n / 4)); }
  Rgb diffuse(const Vec3f&, const Vec3f&) const { return base * INV_PI; }
  Rgb diffuseAlbedo(const Vec3f&) const { return base; }

 private:
  /** cos^e of the angle between a unit vector and the normal. It is computed from the sine, because
   * rounding of the cosine is amplified by large exponents. */
  static float power(const Vec3f& h, float e) {
    const float sine2 = std::min(square(h.x) + square(h.y), 1.0f);
    return e > 0 ? std::exp(0.5f * e * std::log1p(-sine2)) : 1;
  }

  Rgb specular, base;
  float n, scale;
};

} // namespace

void registerBlinnPhong(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters;
  addGlossParameters(parameters);
  parameters.push_back(realParameter("exponent", "50", "of the cosine between normal and half vector")
                           .range(0, 1e5)
                           .withTexture());
  plugIns.materials.add(
      {{.name = "blinnphong",
        .summary = "Normalised Blinn-Phong gloss and a diffuse part; conserves energy.",
        .parameters = parameters,
        .examples = {"", "\"rgb specular\" [1 .9 .8] \"float exponent\" 0",
                     "\"rgb specular\" [.9 .9 .9] \"rgb reflectance\" [1 1 1] \"float exponent\" 5",
                     "\"rgb specular\" [1 1 1] \"float exponent\" 3000"}},
       [](const Parameters& p, const MaterialContext& c) {
         return glossMaterial(
             [specular = c.textures.rgb(p, "specular"), reflectance = c.textures.rgb(p, "reflectance"),
              exponent = c.textures.real(p, "exponent")](const SurfacePoint& point) {
               return BlinnPhongGloss(specular.at(point), reflectance.at(point), exponent.at(point).r);
             },
             false);
       }});
}

} // namespace recurse
