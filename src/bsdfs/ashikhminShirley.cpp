/** @file
 * Ashikhmin and Shirley 2000, "An Anisotropic Phong BRDF Model": an anisotropic gloss lobe over a diffuse
 * base, which receives the light that the gloss transmits.
 */
#include "bsdfs/microfacet/glossOverDiffuse.h"
#include "bsdfs/microfacet/microfacet.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class AshikhminShirleyGloss {
 public:
  AshikhminShirleyGloss(const Rgb& specular, const Rgb& reflectance, const Vec2f& exponents)
      : specular(specular), n(exponents), base(reflectance * (1.0f - specular) * (28 * INV_PI / 23)) {}
  bool anisotropic() const { return n.x != n.y; }
  bool lossless() const { return false; }

  /** Specular BRDF [1/sr], equation 4 of the paper. */
  Rgb value(const Vec3f& a, const Vec3f& b) const {
    const Vec3f h = halfVector(a, b);
    const float c = glm::dot(a, h), d = c * std::max(a.z, b.z);
    if (!(d > 0)) return BLACK;
    const Rgb fresnel = specular + (1.0f - specular) * fifth(std::max(0.0f, 1 - c)); // c may round above 1
    return fresnel * (halfDensity(h) / (4 * d));
  }
  float pdf(const Vec3f& a, const Vec3f& b) const {
    const Vec3f h = halfVector(a, b);
    const float c = glm::dot(a, h);
    return c > 0 ? halfDensity(h) / (4 * c) : 0;
  }
  /** Equations 9 and 10 of the paper, over the whole circle at once. */
  Vec3f sample(const Vec3f& a, const Vec2f& u, float) const {
    const float angle = 2 * PI * u.y;
    Vec2f way(std::cos(angle) * std::sqrt(n.y + 1), std::sin(angle) * std::sqrt(n.x + 1));
    way = glm::normalize(way);
    const float e = n.x * square(way.x) + n.y * square(way.y);
    const float x = std::log1p(-u.x) * 2 / (e + 1); // ln cos²
    const float sine = std::sqrt(-std::expm1(x));
    return mirrored(a, {way.x * sine, way.y * sine, std::exp(x / 2)});
  }
  Rgb albedo(const Vec3f& a) const {
    const float mean = std::sqrt(n.x * n.y); // mean exponent; wide lobes have no grazing facets
    return specular * (0.4f + 0.6f * a.z) + (1.0f - specular) * (fifth(1 - a.z) * mean / (mean + 20));
  }
  /** Diffuse BRDF [1/sr], equation 5 of the paper. */
  Rgb diffuse(const Vec3f& a, const Vec3f& b) const {
    return base * ((1 - fifth(1 - a.z / 2)) * (1 - fifth(1 - b.z / 2)));
  }
  Rgb diffuseAlbedo(const Vec3f& a) const {
    return base * (23 * PI / 28 * 0.975f * (1 - fifth(1 - a.z / 2)));
  }

 private:
  static float fifth(float x) { return square(square(x)) * x; }
  /** Density of half vectors [1/sr], equation 6 of the paper: cos^(nu cos² φ + nv sin² φ), normalised. */
  float halfDensity(const Vec3f& h) const {
    const float sine2 = std::min(square(h.x) + square(h.y), 1.0f);
    const float e = n.x * square(h.x) + n.y * square(h.y); // exponent times sin²
    const float x = sine2 < 1 ? (sine2 > 0 ? 0.5f * std::log1p(-sine2) * (e / sine2) : 0) : -INFINITE;
    return std::sqrt((n.x + 1) * (n.y + 1)) * (INV_PI / 2) * (e == 0 ? 1 : std::exp(x));
  }

  Rgb specular;
  Vec2f n;
  Rgb base;
};

} // namespace

void registerAshikhminShirley(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters;
  addGlossParameters(parameters);
  for (const char* axis : {"u", "v"})
    parameters.push_back(
        realParameter(std::string(axis) + "exponent", "100", std::string("Phong exponent along ") + axis)
            .range(0, 1e5)
            .withTexture());
  plugIns.materials.add(
      {{.name = "ashikhminshirley",
        .summary =
            "Ashikhmin and Shirley's anisotropic Phong gloss with Fresnel reflection over a diffuse base.",
        .parameters = parameters,
        .examples = {"", "\"rgb specular\" [1 1 1] \"float uexponent\" 10 \"float vexponent\" 1000",
                     "\"rgb specular\" [.1 .2 .3] \"rgb reflectance\" [1 1 1] \"float uexponent\" 0 "
                     "\"float vexponent\" 0",
                     "\"rgb specular\" [.05 .05 .05] \"rgb reflectance\" [1 1 1] \"float uexponent\" 3000 "
                     "\"float vexponent\" 3000",
                     "\"rgb specular\" [1 1 1] \"float uexponent\" 30000 \"float vexponent\" 20000"}},
       [](const Parameters& p, const MaterialContext& c) {
         return glossMaterial(
             [specular = c.textures.rgb(p, "specular"), reflectance = c.textures.rgb(p, "reflectance"),
              u = c.textures.real(p, "uexponent"),
              v = c.textures.real(p, "vexponent")](const SurfacePoint& point) {
               return AshikhminShirleyGloss(specular.at(point), reflectance.at(point),
                                            Vec2f(u.at(point).r, v.at(point).r));
             },
             true);
       }});
}

} // namespace recurse
