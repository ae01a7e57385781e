/** @file
 * Milk, skin, marble and the like: a dielectric interface, and the scattering medium inside it.
 */
#include "bsdfs/microfacet/dielectricInterface.h"
#include "bsdfs/microfacet/roughness.h"
#include "recurse/model/medium/mediumParameters.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Subsurface final : public Material {
 public:
  Subsurface(float eta, const Roughness& roughness) : eta(eta), roughness(roughness) {}
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    const Microfacets facets = roughness.at(point);
    if (eta == 1 || facets.smooth()) return arena.make<DielectricBsdf>(eta);
    return arena.make<SingleScatteringDielectric>(DielectricInterface{eta, facets});
  }
  LobeSet lobes() const override {
    return LobeSet((eta != 1 && roughness.neverSmooth() ? NO_LOBE : MIRROR | REFRACTION) |
                   (eta == 1 || roughness.alwaysSmooth() ? NO_LOBE : NON_DELTA_LOBES | ANISOTROPIC));
  }
  float indexInside() const override { return eta; }

 private:
  float eta;
  Roughness roughness;
};

/** Fraction of diffuse light from inside that the boundary reflects. */
double internalReflectance(double eta) {
  constexpr int STEPS = 256;
  double outside = 0; // reflectance from outside: ∫ F(μ) 2 μ dμ
  for (int i = 0; i < STEPS; ++i) {
    const double cosine = (i + 0.5) / STEPS;
    outside += double(dielectricFresnel(float(cosine), float(eta)).reflectance) * 2 * cosine / STEPS;
  }
  return 1 - (1 - outside) / (eta * eta);
}

/**
 * Single-scattering albedo of a half-space that returns the fraction `reflectance` of the light that has
 * entered it. Internal reflection follows Saunderson 1942, the spherical albedo of the medium van de Hulst
 * 1980 (Multiple Light Scattering, volume 2), and anisotropy the similarity relation.
 */
double albedoOf(double reflectance, double internal, double g) {
  const double below = reflectance / (1 - internal * (1 - reflectance));
  // below = (1 - s) (1 - 0.139 s) / (1 + 1.17 s), where s² = (1 - albedo) / (1 - g albedo).
  const double b = 1.139 + 1.17 * below, c = 1 - below;
  const double s = 2 * c / (b + std::sqrt(b * b - 4 * 0.139 * c));
  return (1 - s * s) / (1 - g * s * s);
}

/** Value of a colour parameter. For a texture it is the mean over the surface coordinates, because the
 * medium is homogeneous. */
Rgbd meanColour(const Parameters& p, const MaterialContext& c, const std::string& name) {
  if (p.texture(name).empty()) return p.spectrum(name);
  const TexturedRgb texture = c.textures.rgb(p, name);
  p.warn(name, "the medium inside must be homogeneous: it uses the mean of the texture");
  if (!texture.texture) return BLACK;
  constexpr int SIDE = 32;
  Rgbd sum(0);
  SurfacePoint point{};
  point.geometricNormal = point.shadingNormal = {0, 0, 1};
  for (int i = 0; i < SIDE * SIDE; ++i) {
    point.uv = (Vec2f(i % SIDE, i / SIDE) + 0.5f) / float(SIDE);
    sum += Rgbd(texture.at(point));
  }
  return sum / double(SIDE * SIDE);
}

struct Inside {
  Rgbd absorption, scattering; ///< [1/length]
  double g;
};

Inside fromReflectance(const Parameters& p, const MaterialContext& c) {
  const Rgbd reflectance = meanColour(p, c, "reflectance");
  const Rgbd meanFreePath = meanColour(p, c, "mfp") * p.real("scale");
  if (!(std::min({meanFreePath.r, meanFreePath.g, meanFreePath.b}) > 0))
    p.fail(p.has("mfp") ? "mfp" : "scale", "a mean free path is 0: no light could enter", "lengths above 0");
  Inside inside{Rgbd(0), Rgbd(0), p.real("g")};
  const double internal = internalReflectance(p.real("eta"));
  for (int i = 0; i < 3; ++i) {
    const double albedo = albedoOf(std::clamp(reflectance[i], 0.0, 1.0), internal, inside.g);
    inside.scattering[i] = albedo / meanFreePath[i];
    inside.absorption[i] = (1 - albedo) / meanFreePath[i];
  }
  return inside;
}

/** Coefficients of the medium. As in pbrt, a name precedes coefficients, and these precede a reflectance. */
Inside insideOf(const Parameters& p, const MaterialContext& c) {
  const double scale = p.real("scale");
  if (p.has("name")) {
    if (p.real("g") != 0) p.warn("g", "measured materials have reduced scattering, so that g is 0");
    const MediumPoint known = mediumPreset(p.string("name")).value();
    return {Rgbd(known.absorption) * scale, Rgbd(known.scattering) * scale, 0};
  }
  if (p.has("sigma_a") != p.has("sigma_s"))
    p.fail(p.has("sigma_a") ? "sigma_a" : "sigma_s", "only one of sigma_a and sigma_s is given",
           "both, or \"reflectance\" and \"mfp\"");
  if (!p.has("sigma_a") && p.has("reflectance")) return fromReflectance(p, c);
  if (p.has("mfp") && !p.has("reflectance")) p.warn("mfp", "it is used only together with \"reflectance\"");
  return {meanColour(p, c, "sigma_a") * scale, meanColour(p, c, "sigma_s") * scale, p.real("g")};
}

std::unique_ptr<const ParsedDirective> homogeneous(const Inside& inside, const SourceLocation& where) {
  auto medium = std::make_unique<ParsedDirective>();
  medium->type = "homogeneous";
  medium->location = where;
  const auto add = [&](const char* type, const char* name, std::vector<double> numbers) {
    ParsedParameter p;
    p.type = type;
    p.name = name;
    p.numbers = std::move(numbers);
    p.location = p.valueLocation = where;
    medium->parameters.push_back(std::move(p));
  };
  const auto& [a, s, g] = inside;
  add("rgb", "sigma_a", {a.r, a.g, a.b});
  add("rgb", "sigma_s", {s.r, s.g, s.b});
  add("float", "g", {g});
  return medium;
}

} // namespace

void registerSubsurface(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = {
      stringParameter("name", "", "measured material; lengths in millimetres").oneOf(mediumPresetNames()),
      spectrumParameter("sigma_a", ".0011 .0024 .014", SpectrumKind::UNBOUNDED, "absorption [1/length]")
          .withTexture(),
      spectrumParameter("sigma_s", "2.55 3.21 3.77", SpectrumKind::UNBOUNDED, "scattering [1/length]")
          .withTexture(),
      spectrumParameter("reflectance", "", SpectrumKind::ALBEDO,
                        "multiple-scattering albedo: the fraction of light that leaves a thick piece again; "
                        "instead of sigma_a and sigma_s")
          .withTexture(),
      spectrumParameter("mfp", "1", SpectrumKind::UNBOUNDED, "mean free path, with reflectance [length]")
          .withTexture(),
      realParameter("g", "0", "asymmetry of the scattering, from -1 (backward) to 1 (forward)")
          .range(-0.999, 0.999),
      realParameter("scale", "1", "factor on sigma_a and sigma_s, or on mfp").range(0, 1e30),
      realParameter("eta", "1.33", "refractive index inside over outside").range(1e-3, 1e3)};
  addRoughnessParameters(parameters);
  plugIns.materials.add(
      {{.name = "subsurface",
        .summary = "Milk, skin, marble: a dielectric boundary with a homogeneous medium inside of the shape, "
                   "which replaces that of MediumInterface.",
        .parameters = parameters,
        .examples = {"", "\"string name\" \"Marble\" \"float eta\" 1.5",
                     "\"rgb reflectance\" [ .8 .6 .4 ] \"float mfp\" .1 \"float roughness\" .3",
                     "\"rgb sigma_a\" [ .1 .2 .3 ] \"rgb sigma_s\" [ 1 2 3 ] \"float g\" .5"}},
       [](const Parameters& p, const MaterialContext& c) {
         auto made = std::make_unique<Subsurface>(float(p.real("eta")), Roughness(p, c.textures));
         made->filling = homogeneous(insideOf(p, c), p.location());
         return made;
       }});
}

} // namespace recurse
