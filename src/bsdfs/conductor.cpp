/** @file
 * Smooth and rough metals: mirror or microfacet reflection with the Fresnel reflectance of a conductor.
 */
#include "bsdfs/microfacet/conductorOptics.h"
#include "bsdfs/microfacet/facetLosses.h"
#include "bsdfs/microfacet/roughness.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class MirrorBsdf final : public Bsdf {
 public:
  explicit MirrorBsdf(const ConductorOptics& optics) : optics(optics) {}
  LobeSet lobes() const override { return MIRROR; }
  void deltas(const Vec3f& wi, DeltaScatters& out) const override {
    out.add({{-wi.x, -wi.y, wi.z}, optics.reflectance(std::abs(wi.z)), 1, MIRROR});
  }

 private:
  ConductorOptics optics;
};

class RoughConductorBsdf : public Bsdf {
 public:
  RoughConductorBsdf(const ConductorOptics& optics, const Microfacets& facets)
      : optics(optics), facets(facets) {}
  LobeSet lobes() const override { return facets.anisotropic() ? REFLECTION | ANISOTROPIC : REFLECTION; }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    if (!(wi.z * wo.z > 0)) return BLACK;
    const Vec3f m = halfVector(wi, wo);
    return optics.reflectance(absDot(wi, m)) * facets.reflection(wi, wo, m);
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    return wi.z * wo.z > 0 ? facets.reflectionPdf(wi, halfVector(wi, wo)) : 0;
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float) const override {
    const float side = wi.z > 0 ? 1.0f : -1.0f;
    const Vec3f wo = mirrored(wi, facets.sampleVisible(wi * side, u) * side);
    if (!(wo.z * side > 0)) return {};
    return glm::normalize(wo);
  }
  Rgb albedo(const Vec3f& wi) const override { return optics.reflectance(std::abs(wi.z)); }

 protected:
  ~RoughConductorBsdf() = default;
  ConductorOptics optics;
  Microfacets facets;
};

class SingleScatteringConductor final : public RoughConductorBsdf {
 public:
  using RoughConductorBsdf::RoughConductorBsdf;
};

/** Single scattering plus light that hits several facets: the lost energy times the reflectance of all
 * further facets (Kulla and Conty 2017, with the Fresnel factor of Hill 2018, "A Multi-Faceted Exploration").
 */
class MultipleScatteringConductor final : public RoughConductorBsdf {
 public:
  MultipleScatteringConductor(const ConductorOptics& optics, const Rgb& meanReflectance,
                              const Microfacets& facets, const FacetLosses& losses)
      : RoughConductorBsdf(optics, facets), losses(&losses), meanLost(losses.meanLost(facets)) {
    further = meanReflectance * meanReflectance * (1 - meanLost) / (1.0f - meanReflectance * meanLost);
    white = meanReflectance.r > 0.999f && meanReflectance.g > 0.999f && meanReflectance.b > 0.999f;
  }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    if (!(wi.z * wo.z > 0)) return BLACK;
    return RoughConductorBsdf::value(wi, wo) + further * (lost(wi) * lost(wo) / meanLost * INV_PI);
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    if (!(wi.z * wo.z > 0)) return 0;
    const float more = lost(wi);
    return (1 - more) * RoughConductorBsdf::pdf(wi, wo) + more * std::abs(wo.z) * INV_PI;
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    if (pick >= lost(wi)) return RoughConductorBsdf::sample(wi, u, pick);
    const Vec3f wo = cosineHemisphere(u);
    return Vec3f(wo.x, wo.y, std::copysign(wo.z, wi.z));
  }
  Rgb albedo(const Vec3f& wi) const override {
    const float more = lost(wi);
    return min(RoughConductorBsdf::albedo(wi) * (1 - more) + further * more, Rgb(1));
  }
  bool lossless() const override { return white; }

 private:
  float lost(const Vec3f& w) const { return losses->lost(w, facets); }

  const FacetLosses* losses;
  float meanLost;
  Rgb further; ///< fraction of the lost energy that leaves after further facets
  bool white;
};

/** Weight of one sample of single scattering by perfectly reflecting facets. */
float mirrorAlbedo(const Vec3f& wi, const Microfacets& facets, const Vec2f& u) {
  const Vec3f m = facets.sampleVisible(wi, u), wo = mirrored(wi, m);
  const float p = wo.z > 0 ? facets.reflectionPdf(wi, m) : 0;
  return p > 0 ? facets.reflection(wi, wo, m) * wo.z / p : 0;
}

class Conductor final : public Material {
 public:
  Conductor(const ConductorParameters& optics, const ThinFilmParameters& film, const Roughness& roughness,
            bool multiple)
      : optics(optics), film(film), roughness(roughness) {
    if (!multiple) return;
    losses = FacetLosses(roughness, mirrorAlbedo);
    if (!optics.textured() && !film.textured()) meanReflectance = opticsAt({}).meanReflectance();
  }
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    const Microfacets facets = roughness.at(point);
    const ConductorOptics here = opticsAt(point);
    if (facets.smooth()) return arena.make<MirrorBsdf>(here);
    if (losses.empty()) return arena.make<SingleScatteringConductor>(here, facets);
    return arena.make<MultipleScatteringConductor>(
        here, meanReflectance ? *meanReflectance : here.meanReflectance(), facets, losses);
  }
  LobeSet lobes() const override {
    return LobeSet((roughness.neverSmooth() ? NO_LOBE : MIRROR) |
                   (roughness.alwaysSmooth() ? NO_LOBE : REFLECTION | ANISOTROPIC));
  }

 private:
  ConductorOptics opticsAt(const SurfacePoint& point) const {
    ConductorOptics here = optics.at(point);
    here.film = film.at(point);
    return here;
  }

  ConductorParameters optics;
  ThinFilmParameters film;
  Roughness roughness;
  FacetLosses losses;                 ///< empty: single scattering only
  std::optional<Rgb> meanReflectance; ///< set where neither metal nor film is textured
};

} // namespace

void registerConductor(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters;
  addConductorParameters(parameters);
  addRoughnessParameters(parameters);
  addMultipleScatteringParameter(parameters);
  addThinFilmParameters(parameters);
  plugIns.materials.add(
      {{.name = "conductor",
        .summary = "A metal: mirror reflection with Fresnel's equations, blurred by roughness.",
        .parameters = parameters,
        .examples = {"\"rgb reflectance\" [.9 .8 .7]",
                     "\"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"", "",
                     "\"float roughness\" 1e-3 \"bool remaproughness\" false",
                     "\"float roughness\" .03 \"bool remaproughness\" false",
                     "\"float roughness\" .3 \"rgb reflectance\" [.9 .8 .7]",
                     "\"float roughness\" 1 \"rgb reflectance\" [.99 .99 .99]",
                     "\"float uroughness\" .05 \"float vroughness\" .4 \"bool remaproughness\" false",
                     "\"float roughness\" .002 \"string distribution\" \"beckmann\" "
                     "\"bool remaproughness\" false",
                     "\"float uroughness\" .6 \"float vroughness\" .1 \"string distribution\" \"beckmann\"",
                     "\"float roughness\" .3 \"rgb reflectance\" [1 1 1] \"bool multiscatter\" true",
                     "\"float roughness\" 1 \"rgb reflectance\" [1 1 1] \"bool multiscatter\" true",
                     "\"float roughness\" .8 \"bool multiscatter\" true \"string distribution\" \"beckmann\"",
                     "\"float uroughness\" .6 \"float vroughness\" .1 \"rgb reflectance\" [1 1 1] "
                     "\"bool multiscatter\" true",
                     "\"float thinfilm.thickness\" 250 \"float thinfilm.eta\" 2.2",
                     "\"float thinfilm.thickness\" 600 \"float roughness\" .1",
                     "\"float thinfilm.thickness\" 90 \"rgb reflectance\" [.9 .8 .7] \"float roughness\" .5 "
                     "\"bool multiscatter\" true"}},
       [](const Parameters& p, const MaterialContext& c) {
         const Roughness roughness(p, c.textures);
         return std::make_unique<Conductor>(ConductorParameters(p, c.textures),
                                            ThinFilmParameters(p, c.textures), roughness,
                                            wantsMultipleScattering(p, roughness));
       }});
}

} // namespace recurse
