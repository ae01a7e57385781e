/** @file
 * Coated materials of pbrt-v4: a dielectric layer, optionally filled with a scattering medium, on a diffuse
 * or a metal base.
 */
#include "bsdfs/coated/coatedBsdf.h"
#include "bsdfs/microfacet/roughness.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Parameters of the coat; `prefix` precedes the names of its surface parameters. */
struct CoatParameters {
  CoatParameters(const Parameters& p, const TextureLookup& textures, const std::string& prefix)
      : roughness(p, textures, prefix), thickness(textures.real(p, "thickness")), g(textures.real(p, "g")),
        albedo(textures.rgb(p, "albedo")), eta(static_cast<float>(p.spectrum(prefix + "eta").g)),
        maxDepth(p.integer("maxdepth")), samples(p.integer("nsamples")) {}

  static void declare(std::vector<ParameterSpec>& parameters, const std::string& prefix) {
    parameters.push_back(spectrumParameter(prefix + "eta", "1.5", SpectrumKind::UNBOUNDED,
                                           "refractive index of the coat; a spectrum is evaluated at green")
                             .range(1, 1e3));
    addRoughnessParameters(parameters, prefix);
    parameters.push_back(
        realParameter("thickness", "0.01",
                      "thickness of the coat [mean free paths of the medium in it, which absorbs 1 - albedo]")
            .range(0, 1e6)
            .withTexture());
    parameters.push_back(spectrumParameter("albedo", "0", SpectrumKind::ALBEDO,
                                           "scattering albedo of the medium inside the coat")
                             .withTexture());
    parameters.push_back(realParameter("g", "0", "mean cosine of scattering in the medium")
                             .range(-0.999, 0.999)
                             .withTexture());
    parameters.push_back(
        integerParameter("maxdepth", "10",
                         "maximum number of interactions of a random walk with the two faces of the coat")
            .range(1, 1e6));
    parameters.push_back(
        integerParameter("nsamples", "1", "number of random walks for each evaluation; fewer give more noise")
            .range(1, 1e6));
  }

  DielectricInterface surface(const SurfacePoint& point) const {
    if (eta == 1) return {eta, {}}; // equal indices: no interface, thus no roughness
    return {eta, roughness.at(point)};
  }
  CoatMedium medium(const SurfacePoint& point) const {
    return {thickness.at(point).r, albedo.at(point), g.at(point).r, maxDepth, samples};
  }
  static constexpr float MAX_TABULATED = 1; ///< largest alpha of the tables
  /** Tables of the coat. Null where its medium scatters, or where they would depend on further parameters. */
  std::shared_ptr<const ClearCoat> clear() const {
    if (albedo.texture || !isBlack(albedo.constant) || thickness.texture || roughness.anisotropic())
      return {};
    float minAlpha = Microfacets::SMOOTH_BELOW, maxAlpha = MAX_TABULATED;
    if (!roughness.textured()) {
      const float alpha = surface(SurfacePoint{}).facets.roughness().x;
      if (alpha > MAX_TABULATED) return {};
      minAlpha = maxAlpha = alpha;
    }
    return ClearCoat::make(eta, roughness.kind, minAlpha, maxAlpha, thickness.constant.r);
  }
  LobeSet lobes() const {
    return LobeSet(REFLECTION | ANISOTROPIC | (eta != 1 && roughness.neverSmooth() ? NO_LOBE : MIRROR));
  }

  Roughness roughness;
  TexturedRgb thickness, g, albedo;
  float eta;
  int maxDepth, samples;
};

class CoatedDiffuse final : public Material {
 public:
  CoatedDiffuse(const CoatParameters& coat, const TexturedRgb& reflectance)
      : coat(coat), reflectance(reflectance), clear(coat.clear()) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    const Rgb r = reflectance.at(point);
    const DielectricInterface surface = coat.surface(point);
    const bool tabulated = clear && surface.facets.roughness().x <= CoatParameters::MAX_TABULATED;
    return arena.make<CoatedBsdf<DiffuseBase>>(surface, DiffuseBase{r}, coat.medium(point),
                                               tabulated ? clear.get() : nullptr);
  }
  LobeSet lobes() const override { return coat.lobes(); }

 private:
  CoatParameters coat;
  TexturedRgb reflectance;
  std::shared_ptr<const ClearCoat> clear;
};

class CoatedConductor final : public Material {
 public:
  CoatedConductor(const CoatParameters& coat, const ConductorParameters& metal, const Roughness& roughness)
      : coat(coat), metal(metal), roughness(roughness) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    ConductorOptics optics = metal.at(point);
    optics.eta /= coat.eta; // index relative to the coat, not to air
    optics.k /= coat.eta;
    return arena.make<CoatedBsdf<ConductorBase>>(
        coat.surface(point), ConductorBase{optics, roughness.at(point)}, coat.medium(point));
  }
  LobeSet lobes() const override { return coat.lobes(); }

 private:
  CoatParameters coat;
  ConductorParameters metal;
  Roughness roughness;
};

} // namespace

void registerCoated(PlugIns& plugIns) {
  std::vector<ParameterSpec> diffuse = {
      spectrumParameter("reflectance", "0.5", SpectrumKind::ALBEDO, "albedo of the diffuse base")
          .withTexture()};
  CoatParameters::declare(diffuse, "");
  plugIns.materials.add(
      {{.name = "coateddiffuse",
        .summary = "A diffuse base below a dielectric coat, smooth or rough.",
        .parameters = diffuse,
        .examples = {"",
                     "\"rgb reflectance\" [.9 .5 .1] \"float roughness\" .2 \"bool remaproughness\" false",
                     "\"rgb reflectance\" [1 1 1] \"float roughness\" .01 \"float thickness\" 0",
                     "\"float uroughness\" .02 \"float vroughness\" .4 \"float eta\" 1.8",
                     "\"rgb albedo\" [.9 .7 .5] \"float thickness\" .5 \"float g\" .4",
                     "\"rgb albedo\" [.8 .8 .9] \"float thickness\" 2 \"float roughness\" .1"}},
       [](const Parameters& p, const MaterialContext& c) {
         return std::make_unique<CoatedDiffuse>(CoatParameters(p, c.textures, ""),
                                                c.textures.rgb(p, "reflectance"));
       }});
  std::vector<ParameterSpec> conductor;
  addConductorParameters(conductor, "conductor.");
  addRoughnessParameters(conductor, "conductor.");
  CoatParameters::declare(conductor, "interface.");
  plugIns.materials.add({{.name = "coatedconductor",
                          .summary = "A metal below a dielectric coat; each is smooth or rough.",
                          .parameters = conductor,
                          .examples = {"", "\"rgb reflectance\" [.8 .7 .3] \"float conductor.roughness\" .1",
                                       "\"rgb reflectance\" [.8 .8 .8] \"float interface.roughness\" .05 "
                                       "\"float conductor.roughness\" .3 \"bool remaproughness\" false",
                                       "\"float interface.roughness\" .04 \"float conductor.roughness\" 0",
                                       "\"float conductor.uroughness\" .01 \"float conductor.vroughness\" .3 "
                                       "\"rgb albedo\" [.5 .6 .7] \"float thickness\" .3"}},
                         [](const Parameters& p, const MaterialContext& c) {
                           return std::make_unique<CoatedConductor>(
                               CoatParameters(p, c.textures, "interface."),
                               ConductorParameters(p, c.textures, "conductor."),
                               Roughness(p, c.textures, "conductor."));
                         }});
}

} // namespace recurse
