/** @file
 * A smooth interface between two dielectrics: Fresnel reflection and refraction.
 */
#include "recurse/model/fresnel.h"
#include "recurse/model/plugIns.h"
#include "recurse/model/roughness.h"

namespace recurse {

namespace {

class DielectricBsdf final : public Bsdf {
 public:
  explicit DielectricBsdf(float eta) : eta(eta) {}
  LobeSet lobes() const override { return MIRROR | REFRACTION; }
  void deltas(const Vec3f& wi, DeltaScatters& out) const override {
    const float relative = wi.z > 0 ? eta : 1 / eta; // beyond over here
    const DielectricFresnel f = dielectricFresnel(std::min(std::abs(wi.z), 1.0f), relative);
    if (f.reflectance > 0) out.add({{-wi.x, -wi.y, wi.z}, Rgb(f.reflectance), 1, MIRROR});
    if (f.reflectance < 1)
      out.add({{-wi.x / relative, -wi.y / relative, -std::copysign(f.cosTransmitted, wi.z)},
               Rgb(1 - f.reflectance),
               relative,
               REFRACTION});
  }

 private:
  float eta;
};

class Dielectric final : public Material {
 public:
  explicit Dielectric(float eta) : eta(eta) {}
  const Bsdf* bsdfAt(const SurfacePoint&, BsdfArena& arena) const override {
    return arena.make<DielectricBsdf>(eta);
  }
  LobeSet lobes() const override { return MIRROR | REFRACTION; }

 private:
  float eta;
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
        .summary = "Smooth glass, water and the like: Fresnel reflection and refraction.",
        .parameters = parameters,
        .examples = {"\"float eta\" 1.5", "\"float eta\" 0.75", "\"spectrum eta\" \"glass-BK7\""}},
       [](const Parameters& p, const MaterialContext&) {
         refuseRoughness(p);
         return std::make_unique<Dielectric>(static_cast<float>(p.spectrum("eta").g));
       }});
}

} // namespace recurse
