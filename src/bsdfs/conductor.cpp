/** @file
 * Smooth metals: a mirror with the Fresnel reflectance of a conductor.
 */
#include "recurse/model/fresnel.h"
#include "recurse/model/plugIns.h"
#include "recurse/model/roughness.h"

namespace recurse {

namespace {

class ConductorBsdf final : public Bsdf {
 public:
  ConductorBsdf(const Rgb& eta, const Rgb& k) : eta(eta), k(k) {}
  LobeSet lobes() const override { return MIRROR; }
  void deltas(const Vec3f& wi, DeltaScatters& out) const override {
    const float c = std::min(std::abs(wi.z), 1.0f);
    Rgb reflectance;
    for (int i = 0; i < 3; ++i) reflectance[i] = conductorFresnel(c, eta[i], k[i]);
    out.add({{-wi.x, -wi.y, wi.z}, reflectance, 1, MIRROR});
  }

 private:
  Rgb eta, k;
};

class Conductor final : public Material {
 public:
  Conductor(const TexturedRgb& eta, const TexturedRgb& k) : eta(eta), k(k) {}
  explicit Conductor(const TexturedRgb& reflectance) : reflectance(reflectance), fromReflectance(true) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    if (!fromReflectance) return arena.make<ConductorBsdf>(eta.at(point), k.at(point));
    // pbrt's meaning of `reflectance`: the conductor with eta 1 that has this reflectance at normal
    // incidence. A reflectance of 1 would need an infinite k; 0.9999 is pbrt's limit.
    const Rgb r = glm::min(reflectance.at(point), Rgb(0.9999f));
    return arena.make<ConductorBsdf>(Rgb(1), 2.0f * glm::sqrt(r) / glm::sqrt(1.0f - r));
  }
  LobeSet lobes() const override { return MIRROR; }

 private:
  TexturedRgb eta, k, reflectance;
  bool fromReflectance = false;
};

} // namespace

void registerConductor(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = {
      spectrumParameter("eta", "", SpectrumKind::UNBOUNDED,
                        "refractive index; metal-Cu-eta when neither is given")
          .withTexture(),
      spectrumParameter("k", "", SpectrumKind::UNBOUNDED,
                        "absorption coefficient; metal-Cu-k when neither is given")
          .withTexture(),
      spectrumParameter("reflectance", "", SpectrumKind::ALBEDO,
                        "reflectance at normal incidence instead of eta and k: stands for eta = 1 and "
                        "k = 2 sqrt(r) / sqrt(1 - r), so that it grows towards 1 at grazing incidence")
          .withTexture()};
  addRoughnessParameters(parameters);
  plugIns.materials.add(
      {{.name = "conductor",
        .summary = "A smooth metal: mirror reflection with Fresnel's formulas.",
        .parameters = parameters,
        .examples = {"\"rgb reflectance\" [.9 .8 .7]",
                     "\"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"", ""}},
       [](const Parameters& p, const MaterialContext& c) -> std::unique_ptr<Material> {
         refuseRoughness(p);
         if (p.has("reflectance")) {
           for (const char* other : {"eta", "k"})
             if (p.has(other))
               p.fail(other, "both \"reflectance\" and \"" + std::string(other) + "\" are given",
                      "either of the two");
           return std::make_unique<Conductor>(c.textures.rgb(p, "reflectance"));
         }
         // Copper at 611, 549 and 464 nm (P. B. Johnson and R. W. Christy 1972), pbrt's default metal.
         const TexturedRgb copperEta{{0.2004f, 0.9240f, 1.1022f}}, copperK{{3.9129f, 2.4528f, 2.1421f}};
         return std::make_unique<Conductor>(p.has("eta") ? c.textures.rgb(p, "eta") : copperEta,
                                            p.has("k") ? c.textures.rgb(p, "k") : copperK);
       }});
}

} // namespace recurse
