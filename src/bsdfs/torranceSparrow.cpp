/** @file
 * The model of Torrance and Sparrow 1967, "Theory for Off-Specular Reflection From Roughened Surfaces":
 * facets in V-shaped grooves, whose geometrical factor it introduced, with a choice of distributions, and a
 * diffuse part.
 */
#include "bsdfs/microfacet/conductorOptics.h"
#include "bsdfs/microfacet/glossOverDiffuse.h"
#include "bsdfs/microfacet/microfacet.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

enum class FacetTilt { GAUSSIAN, BECKMANN, TROWBRIDGE_REITZ, BLINN };

/** Isotropic distribution D of the facets' tilt; the integral of D cos over the hemisphere is 1. */
class TiltDistribution {
 public:
  TiltDistribution(FacetTilt kind, float m)
      : kind(kind), m(m),
        facets(kind == FacetTilt::BECKMANN ? MicrofacetKind::BECKMANN : MicrofacetKind::TROWBRIDGE_REITZ,
               Vec2f(m)) {
    if (kind == FacetTilt::GAUSSIAN) {
      // 1 / (π ∫ exp(-θ²/m²) sin 2θ dθ) by Simpson's rule over the effective support.
      constexpr int N = 64;
      const float end = std::min(PI / 2, 6 * m), h = end / N;
      float sum = 0;
      for (int i = 0; i <= N; ++i) {
        const float theta = h * static_cast<float>(i);
        const float weight = i == 0 || i == N ? 1.0f : i % 2 ? 4.0f : 2.0f;
        sum += weight * std::exp(-square(theta / m)) * std::sin(2 * theta);
      }
      scale = 3 / (h * sum * PI);
    }
    exponent = std::max(2 / square(m) - 2, 0.0f); // Blinn's exponent for the same slopes (Walter et al. 2007)
  }

  float density(const Vec3f& h) const {
    const float sine2 = std::min(square(h.x) + square(h.y), 1.0f);
    switch (kind) {
    case FacetTilt::GAUSSIAN:
      return scale * std::exp(-square(std::atan2(std::sqrt(sine2), h.z) / m));
    case FacetTilt::BLINN:
      return (exponent + 2) / (2 * PI) * (exponent > 0 ? std::exp(0.5f * exponent * std::log1p(-sine2)) : 1);
    default:
      return facets.density(h);
    }
  }
  /** Distribution that sample() follows: density(), except for the Gaussian, which has no inverse. */
  float sampledDensity(const Vec3f& h) const {
    return kind == FacetTilt::GAUSSIAN ? facets.density(h) : density(h);
  }
  /** A unit normal with density sampledDensity · cos. */
  Vec3f sample(const Vec2f& u) const {
    const float phi = 2 * PI * u.y;
    float slope2 = 0;
    switch (kind) {
    case FacetTilt::BLINN:
      slope2 = std::expm1(-std::log1p(-u.x) * 2 / (exponent + 2)); // 1/cos² - 1
      break;
    case FacetTilt::BECKMANN:
      slope2 = -square(m) * std::log1p(-u.x);
      break;
    default:
      slope2 = square(m) * u.x / (1 - u.x);
    }
    const float slope = std::sqrt(slope2);
    return glm::normalize(Vec3f(slope * std::cos(phi), slope * std::sin(phi), 1));
  }

 private:
  FacetTilt kind;
  float m, scale = 1, exponent = 0;
  Microfacets facets;
};

class TorranceSparrowGloss {
 public:
  TorranceSparrowGloss(const Rgb& specular, const Rgb& reflectance, const ConductorOptics& optics,
                       const TiltDistribution& tilt)
      : specular(specular), base(reflectance * (1.0f - specular)), optics(optics), tilt(tilt) {}
  bool anisotropic() const { return false; }
  bool lossless() const { return false; }
  Rgb value(const Vec3f& a, const Vec3f& b) const {
    const Vec3f h = halfVector(a, b);
    const float c = glm::dot(a, h);
    if (!(c > 0 && a.z > 0 && b.z > 0)) return BLACK;
    // G over both cosines: each of the three cases of the groove is divided before any factor vanishes.
    const float groove =
        std::min(1 / std::max(a.z, b.z) / std::min(a.z, b.z), 2 * h.z / (c * std::max(a.z, b.z)));
    return specular * optics.reflectance(c) * (0.25f * tilt.density(h) * groove);
  }
  float pdf(const Vec3f& a, const Vec3f& b) const {
    const Vec3f h = halfVector(a, b);
    if (!(glm::dot(a, h) > 0)) return 0;
    return tilt.sampledDensity(h) * h.z / (2 * seen(a, h));
  }
  /** Samples a wall of a groove by its visible area (as Heitz and d'Eon 2014 do for Smith's surface). */
  Vec3f sample(const Vec3f& a, const Vec2f& u, float pick) const {
    Vec3f h = tilt.sample(u);
    const float own = std::max(glm::dot(a, h), 0.0f);
    if (pick * seen(a, h) >= own) h = {-h.x, -h.y, h.z};
    return mirrored(a, h);
  }
  Rgb albedo(const Vec3f& a) const { return specular * optics.reflectance(a.z) * (0.6f + 0.4f * a.z); }
  Rgb diffuse(const Vec3f&, const Vec3f&) const { return base * INV_PI; }
  Rgb diffuseAlbedo(const Vec3f&) const { return base; }

 private:
  /** Visible area of both walls of the groove. Not zero, because the upper one is visible from everywhere. */
  static float seen(const Vec3f& a, const Vec3f& h) {
    return std::max(glm::dot(a, h), 0.0f) + std::max(h.z * a.z - h.x * a.x - h.y * a.y, 0.0f);
  }

  Rgb specular, base;
  ConductorOptics optics;
  TiltDistribution tilt;
};

} // namespace

void registerTorranceSparrow(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters;
  addGlossParameters(parameters);
  parameters.push_back(
      spectrumParameter("eta", "1.5", SpectrumKind::UNBOUNDED, "refractive index of the facets")
          .withTexture());
  parameters.push_back(
      spectrumParameter("k", "0", SpectrumKind::UNBOUNDED, "absorption coefficient of the facets, for metals")
          .withTexture());
  parameters.push_back(realParameter("roughness", "0.3",
                                     "width m of the distribution: of the tilt [rad] (gaussian), or of its "
                                     "tangent (the others); √2 times the standard deviation")
                           .range(1e-3, 1)
                           .withTexture());
  parameters.push_back(stringParameter("distribution", "gaussian",
                                       "distribution of the tilt: the paper's Gaussian, Beckmann's, "
                                       "Trowbridge and Reitz', or Blinn's power of the cosine")
                           .oneOf({"gaussian", "beckmann", "trowbridgereitz", "blinn"}));
  plugIns.materials.add(
      {{.name = "torrancesparrow",
        .summary = "Torrance and Sparrow's V-shaped grooves (1967), and a diffuse part.",
        .parameters = parameters,
        .examples =
            {"", "\"rgb specular\" [1 1 1] \"spectrum eta\" \"metal-Al-eta\" \"spectrum k\" \"metal-Al-k\"",
             "\"rgb specular\" [1 1 1] \"float eta\" 3 \"string distribution\" \"beckmann\" "
             "\"float roughness\" .02",
             "\"rgb specular\" [1 1 1] \"rgb k\" [8 9 7] \"string distribution\" \"trowbridgereitz\" "
             "\"float roughness\" 1",
             "\"rgb specular\" [.5 .4 .6] \"rgb k\" [8 9 7] \"rgb reflectance\" [1 1 1] "
             "\"string distribution\" \"blinn\" \"float roughness\" .5",
             "\"rgb specular\" [1 1 1] \"rgb k\" [9 9 9] \"float roughness\" 1"}},
       [](const Parameters& p, const MaterialContext& c) {
         const std::string name = p.string("distribution");
         const FacetTilt kind = name == "gaussian"   ? FacetTilt::GAUSSIAN
                                : name == "beckmann" ? FacetTilt::BECKMANN
                                : name == "blinn"    ? FacetTilt::BLINN
                                                     : FacetTilt::TROWBRIDGE_REITZ;
         const TexturedRgb m = c.textures.real(p, "roughness");
         const auto tiltAt = [kind, m](const SurfacePoint& point) {
           return TiltDistribution(kind, m.at(point).r);
         };
         return glossMaterial(
             [specular = c.textures.rgb(p, "specular"), reflectance = c.textures.rgb(p, "reflectance"),
              eta = c.textures.rgb(p, "eta"), k = c.textures.rgb(p, "k"), tiltAt,
              varies = m.texture != nullptr, tilt = tiltAt({})](const SurfacePoint& point) {
               return TorranceSparrowGloss(specular.at(point), reflectance.at(point),
                                           {eta.at(point), k.at(point)}, varies ? tiltAt(point) : tilt);
             },
             false);
       }});
}

} // namespace recurse
