/** @file
 * Metals, smooth and rough: mirrors, large or microscopic, with the Fresnel reflectance of a conductor.
 */
#include "recurse/model/conductorOptics.h"
#include "recurse/model/plugIns.h"
#include "recurse/model/roughness.h"

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

class RoughConductorBsdf final : public Bsdf {
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

 private:
  ConductorOptics optics;
  Microfacets facets;
};

class Conductor final : public Material {
 public:
  Conductor(const ConductorParameters& optics, const Roughness& roughness)
      : optics(optics), roughness(roughness) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    const Microfacets facets = roughness.at(point);
    if (facets.smooth()) return arena.make<MirrorBsdf>(optics.at(point));
    return arena.make<RoughConductorBsdf>(optics.at(point), facets);
  }
  LobeSet lobes() const override {
    return LobeSet((roughness.neverSmooth() ? NO_LOBE : MIRROR) |
                   (roughness.alwaysSmooth() ? NO_LOBE : REFLECTION | ANISOTROPIC));
  }

 private:
  ConductorParameters optics;
  Roughness roughness;
};

} // namespace

void registerConductor(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters;
  addConductorParameters(parameters);
  addRoughnessParameters(parameters);
  plugIns.materials.add(
      {{.name = "conductor",
        .summary = "A metal: mirror reflection with Fresnel's formulas, spread by roughness.",
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
                     "\"float uroughness\" .6 \"float vroughness\" .1 \"string distribution\" \"beckmann\""}},
       [](const Parameters& p, const MaterialContext& c) {
         return std::make_unique<Conductor>(ConductorParameters(p, c.textures), Roughness(p, c.textures));
       }});
}

} // namespace recurse
