/** @file
 * A thin pane: both faces of a slab at once, with all reflections between them.
 */
#include "bsdfs/microfacet/fresnel.h"
#include "bsdfs/microfacet/thinFilm.h"
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

/** A pane with a film on one face. */
class FilmedPaneBsdf final : public Bsdf {
 public:
  FilmedPaneBsdf(float eta, const ThinFilm& film) : eta(eta), film(film) {}
  LobeSet lobes() const override { return MIRROR | REFRACTION | STRAIGHT; }
  void deltas(const Vec3f& wi, DeltaScatters& out) const override {
    const float cosine = std::min(std::abs(wi.z), 1.0f);
    const Rgb coated = film.reflectance(cosine, Rgb(eta));
    const float bare = dielectricFresnel(cosine, eta).reflectance;
    // The geometric series over internal reflections, of light without coherence between the two faces; a
    // face without absorption reflects alike from both sides.
    const Rgb transmittance =
        bare < 1 ? clamp((1 - coated) * (1 - bare) / (1.0f - coated * bare), 0.0f, 1.0f) : BLACK;
    const Rgb reflectance = 1 - transmittance;
    if (!isBlack(reflectance)) out.add({{-wi.x, -wi.y, wi.z}, reflectance, 1, MIRROR});
    if (!isBlack(transmittance)) out.add({-wi, transmittance, 1, REFRACTION});
  }
  bool lossless() const override { return true; }

 private:
  float eta;
  ThinFilm film;
};

class ThinDielectric final : public Material {
 public:
  ThinDielectric(float eta, const ThinFilmParameters& film) : eta(eta), film(film) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    const ThinFilm here = film.at(point);
    if (here.exists()) return arena.make<FilmedPaneBsdf>(eta, here);
    return arena.make<ThinDielectricBsdf>(eta);
  }
  LobeSet lobes() const override { return MIRROR | REFRACTION | STRAIGHT; }

 private:
  float eta;
  ThinFilmParameters film;
};

} // namespace

void registerThinDielectric(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = {
      spectrumParameter(
          "eta", "1.5", SpectrumKind::UNBOUNDED,
          "refractive index of the pane relative to its surroundings; a spectrum is evaluated at "
          "green. 1: the film alone, such as a soap bubble")
          .range(1e-3, 1e3)};
  addThinFilmParameters(parameters);
  plugIns.materials.add(
      {{.name = "thindielectric",
        .summary =
            "A thin pane, which light passes straight through; includes reflections between both faces.",
        .parameters = parameters,
        .examples = {"\"float eta\" 1.5", "\"float eta\" 1 \"float thinfilm.thickness\" 400",
                     "\"float thinfilm.thickness\" 300 \"float thinfilm.eta\" 1.45"}},
       [](const Parameters& p, const MaterialContext& c) {
         return std::make_unique<ThinDielectric>(static_cast<float>(p.spectrum("eta").g),
                                                 ThinFilmParameters(p, c.textures));
       }});
}

} // namespace recurse
