/** @file
 * Glass, water and the like: a smooth or rough interface between two dielectrics, with Fresnel reflection and
 * refraction.
 */
#include "recurse/model/dielectricInterface.h"
#include "recurse/model/plugIns.h"
#include "recurse/model/roughness.h"

namespace recurse {

namespace {

class DielectricBsdf final : public Bsdf {
 public:
  explicit DielectricBsdf(float eta) : surface{eta, {}} {}
  LobeSet lobes() const override { return MIRROR | REFRACTION; }
  void deltas(const Vec3f& wi, DeltaScatters& out) const override { surface.deltas(wi, out); }
  bool lossless() const override { return true; }

 private:
  DielectricInterface surface;
};

class RoughDielectricBsdf final : public Bsdf {
 public:
  explicit RoughDielectricBsdf(const DielectricInterface& surface) : surface(surface) {}
  LobeSet lobes() const override {
    return surface.facets.anisotropic() ? DIFFUSE_LOBES | ANISOTROPIC : DIFFUSE_LOBES;
  }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override { return Rgb(surface.value(wi, wo)); }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override { return surface.pdf(wi, wo); }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    return surface.sample(wi, u, pick);
  }
  Rgb albedo(const Vec3f&) const override { return Rgb(1); }
  float eta() const override { return surface.eta; }

 private:
  DielectricInterface surface;
};

class Dielectric final : public Material {
 public:
  Dielectric(float eta, const Roughness& roughness) : eta(eta), roughness(roughness) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    const Microfacets facets = roughness.at(point);
    if (eta == 1 || facets.smooth()) return arena.make<DielectricBsdf>(eta);
    return arena.make<RoughDielectricBsdf>(DielectricInterface{eta, facets});
  }
  LobeSet lobes() const override {
    return LobeSet((eta != 1 && roughness.neverSmooth() ? NO_LOBE : MIRROR | REFRACTION) |
                   (eta == 1 || roughness.alwaysSmooth() ? NO_LOBE : DIFFUSE_LOBES | ANISOTROPIC));
  }

 private:
  float eta;
  Roughness roughness;
};

} // namespace

void registerDielectric(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = {
      spectrumParameter(
          "eta", "1.5", SpectrumKind::UNBOUNDED,
          "refractive index inside over outside (the side of the normal); of a spectrum, the value for green")
          .range(1e-3, 1e3)};
  addRoughnessParameters(parameters);
  plugIns.materials.add(
      {{.name = "dielectric",
        .summary = "Glass, water and the like: Fresnel reflection and refraction, spread by roughness.",
        .parameters = parameters,
        .examples = {"\"float eta\" 1.5", "\"float eta\" 0.75", "\"spectrum eta\" \"glass-BK7\"",
                     "\"float roughness\" .002 \"bool remaproughness\" false",
                     "\"float roughness\" .1 \"bool remaproughness\" false",
                     "\"float roughness\" .4 \"float eta\" .7", "\"float roughness\" 1 \"float eta\" 1.33",
                     "\"float uroughness\" .05 \"float vroughness\" .5",
                     "\"float roughness\" .2 \"float eta\" 2 \"string distribution\" \"beckmann\""}},
       [](const Parameters& p, const MaterialContext& c) {
         return std::make_unique<Dielectric>(static_cast<float>(p.spectrum("eta").g),
                                             Roughness(p, c.textures));
       }});
}

} // namespace recurse
