/** @file
 * A thin pane: both faces of a slab at once, with all reflections between them.
 */
#include "bsdfs/microfacet/fresnel.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class ThinDielectricBsdf final : public Bsdf {
 public:
  explicit ThinDielectricBsdf(float eta) : eta(eta) {}
  LobeSet lobes() const override { return MIRROR | REFRACTION | STRAIGHT; }
  void deltas(const Vec3f& wi, DeltaScatters& out) const override {
    const float r = dielectricFresnel(std::min(std::abs(wi.z), 1.0f), eta).reflectance;
    // The geometric series over internal reflections: R + T² R / (1 − R²) = 2 R / (1 + R).
    const float reflectance = 2 * r / (1 + r);
    if (reflectance > 0) out.add({{-wi.x, -wi.y, wi.z}, Rgb(reflectance), 1, MIRROR});
    if (reflectance < 1) out.add({-wi, Rgb(1 - reflectance), 1, REFRACTION});
  }
  bool lossless() const override { return true; }

 private:
  float eta;
};

class ThinDielectric final : public Material {
 public:
  explicit ThinDielectric(float eta) : eta(eta) {}
  const Bsdf* bsdfAt(const SurfacePoint&, BsdfArena& arena) const override {
    return arena.make<ThinDielectricBsdf>(eta);
  }
  LobeSet lobes() const override { return MIRROR | REFRACTION | STRAIGHT; }

 private:
  float eta;
};

} // namespace

void registerThinDielectric(PlugIns& plugIns) {
  plugIns.materials.add(
      {{.name = "thindielectric",
        .summary =
            "A thin pane, which light passes straight through; includes reflections between both faces.",
        .parameters = {spectrumParameter("eta", "1.5", SpectrumKind::UNBOUNDED,
                                         "refractive index of the pane relative to its surroundings; a "
                                         "spectrum is evaluated at green")
                           .range(1e-3, 1e3)},
        .examples = {"\"float eta\" 1.5"}},
       [](const Parameters& p, const MaterialContext&) {
         return std::make_unique<ThinDielectric>(static_cast<float>(p.spectrum("eta").g));
       }});
}

} // namespace recurse
