/** @file
 * Plastic: a diffuse base below a clear coat, in closed form. Light that the coat transmits reaches the base.
 * The coat reflects part of the light from the base back, repeatedly; the remainder leaves with the angular
 * shape that reciprocity requires (Ashikhmin, Premože, Shirley 2000, "A Microfacet-based BRDF Generator",
 * section 4; the inner reflections as in Egan and Hilgeman 1979). `coateddiffuse` is the same model with
 * random walks in the coat, absorption and media.
 */
#include "bsdfs/microfacet/albedoTable.h"
#include "bsdfs/microfacet/dielectricInterface.h"
#include "bsdfs/microfacet/glossOverDiffuse.h"
#include "bsdfs/microfacet/roughness.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Directional albedo of the reflection by the coat. */
AlbedoTable coatAlbedo(float eta, MicrofacetKind kind, float least, float most) {
  return {least, most, [&](const Vec3f& wi, float alpha, const Vec2f& u) {
            const DielectricInterface coat{eta, {kind, Vec2f(alpha)}};
            const auto s = coat.step(wi, u, REFLECTION);
            return s ? s->weight : 0.0f;
          }};
}

class PlasticBsdf final : public Bsdf {
 public:
  PlasticBsdf(const DielectricInterface& coat, const Rgb& reflectance, const AlbedoTable& table)
      : coat(coat), table(&table), alpha(coat.facets.meanRoughness()) {
    const float mean = table.mean(alpha), inside = 1 - (1 - mean) / square(coat.eta);
    base = reflectance * ((1 - inside) / (1 - mean)) / (1.0f - reflectance * inside);
    white = reflectance == Rgb(1) && !coat.facets.anisotropic();
  }

  LobeSet lobes() const override {
    if (coat.facets.smooth()) return MIRROR | REFLECTION;
    return coat.facets.anisotropic() ? REFLECTION | ANISOTROPIC : REFLECTION;
  }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    if (!(wi.z * wo.z > 0)) return BLACK;
    const Vec3f a = up(wi), b = up(wo);
    const Rgb below = base * (through(a) * through(b) * INV_PI);
    return coat.facets.smooth() ? below : below + coat.value(a, b);
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    if (!(wi.z * wo.z > 0)) return 0;
    const Vec3f a = up(wi), b = up(wo);
    const float glossy = chance(a);
    return (glossy > 0 ? glossy * coat.facets.reflectionPdf(a, halfVector(a, b)) : 0) +
           (1 - glossy) * b.z * INV_PI;
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    const Vec3f a = up(wi);
    const Vec3f wo = pick < chance(a) ? mirrored(a, coat.facets.sampleVisible(a, u)) : cosineHemisphere(u);
    if (!(wo.z > 0)) return {};
    const Vec3f unit = glm::normalize(wo);
    return wi.z < 0 ? Vec3f(unit.x, unit.y, -unit.z) : unit;
  }
  void deltas(const Vec3f& wi, DeltaScatters& out) const override {
    // The tabulated value makes coat and base conserve energy exactly.
    if (coat.facets.smooth()) out.add({{-wi.x, -wi.y, wi.z}, Rgb(1 - through(up(wi))), 1, MIRROR});
  }
  Rgb albedo(const Vec3f& wi) const override {
    const float t = through(up(wi)), mean = table->mean(alpha);
    return min(base * (t * (1 - mean)) + Rgb(coat.facets.smooth() ? 0 : 1 - t), Rgb(1));
  }
  bool lossless() const override { return white; }

 private:
  static Vec3f up(const Vec3f& w) { return {w.x, w.y, std::abs(w.z)}; }
  float through(const Vec3f& w) const { return 1 - table->at(w.z, alpha); }
  float chance(const Vec3f& a) const {
    if (coat.facets.smooth()) return 0;
    const float r = 1 - through(a), d = (1 - r) * maxComponent(base) * (1 - table->mean(alpha));
    return d > 0 ? std::clamp(r / (r + d), 0.05f, 0.95f) : 1;
  }

  DielectricInterface coat;
  const AlbedoTable* table;
  float alpha;
  Rgb base; ///< BRDF of the base times π, over the transmittances of both directions
  bool white;
};

class Plastic final : public Material {
 public:
  Plastic(float eta, const Roughness& roughness, const TexturedRgb& reflectance)
      : eta(eta), roughness(roughness), reflectance(reflectance) {
    const Microfacets facets = roughness.at(SurfacePoint{});
    if (roughness.textured())
      table = coatAlbedo(eta, roughness.kind, 1e-3f, 1);
    else
      table = coatAlbedo(eta, roughness.kind, facets.meanRoughness(), facets.meanRoughness());
  }
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    return arena.make<PlasticBsdf>(DielectricInterface{eta, roughness.at(point)}, reflectance.at(point),
                                   table);
  }
  LobeSet lobes() const override {
    return LobeSet(REFLECTION | ANISOTROPIC | (roughness.neverSmooth() ? NO_LOBE : MIRROR));
  }

 private:
  float eta;
  Roughness roughness;
  TexturedRgb reflectance;
  AlbedoTable table;
};

} // namespace

void registerPlastic(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = {
      spectrumParameter("reflectance", "0.5", SpectrumKind::ALBEDO, "albedo of the base").withTexture(),
      spectrumParameter("eta", "1.5", SpectrumKind::UNBOUNDED,
                        "refractive index of the coat; a spectrum is evaluated at green")
          .range(1.01, 10)};
  addRoughnessParameters(parameters, "", "0.1");
  plugIns.materials.add(
      {{.name = "plastic",
        .summary = "A diffuse base below a clear coat that does not absorb, in closed form without noise.",
        .parameters = parameters,
        .examples =
            {"", "\"rgb reflectance\" [1 1 1] \"float roughness\" 0",
             "\"rgb reflectance\" [1 1 1] \"float roughness\" .3 \"float eta\" 1.8",
             "\"rgb reflectance\" [1 1 1] \"float roughness\" .05 \"string distribution\" \"beckmann\"",
             "\"rgb reflectance\" [.1 .9 .3] \"float uroughness\" .02 \"float vroughness\" .4"}},
       [](const Parameters& p, const MaterialContext& c) {
         return std::make_unique<Plastic>(static_cast<float>(p.spectrum("eta").g), Roughness(p, c.textures),
                                          c.textures.rgb(p, "reflectance"));
       }});
}

} // namespace recurse
