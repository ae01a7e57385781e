/** @file
 * Glass, water and the like: a smooth or rough interface between two dielectrics, with Fresnel reflection and
 * refraction.
 */
#include "bsdfs/microfacet/dielectricInterface.h"
#include "bsdfs/microfacet/facetLosses.h"
#include "bsdfs/microfacet/roughness.h"
#include "bsdfs/microfacet/thinFilm.h"
#include "recurse/model/bsdf/dispersion.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Refraction at one wavelength; the reflectance of white light is the mean over all wavelengths. */
class DispersiveBsdf final : public Bsdf {
 public:
  DispersiveBsdf(const DispersiveIndex& index, float wavelength, bool isWhite)
      : index(index), surface{index.at(wavelength), {}}, isWhite(isWhite) {}
  LobeSet lobes() const override { return MIRROR | REFRACTION | DISPERSIVE; }
  void deltas(const Vec3f& wi, DeltaScatters& out) const override {
    if (!isWhite) {
      surface.deltas(wi, out);
      return;
    }
    DeltaScatters one;
    surface.deltas(wi, one);
    Rgb mirrored(0);
    const float cosine = std::min(std::abs(wi.z), 1.0f);
    for (const DispersiveIndex::Part& part : index.parts())
      mirrored += part.colour * dielectricFresnel(cosine, wi.z > 0 ? part.index : 1 / part.index).reflectance;
    out.add({{-wi.x, -wi.y, wi.z}, clamp(mirrored, 0, 1), 1, MIRROR});
    for (const DeltaScatter& s : one)
      if (s.lobe == REFRACTION) out.add(s);
  }
  bool lossless() const override { return true; }

 private:
  const DispersiveIndex& index;
  DielectricInterface surface;
  bool isWhite;
};

/** Smooth interface with a thin film on its outer side. */
class FilmedDielectricBsdf final : public Bsdf {
 public:
  FilmedDielectricBsdf(float eta, const ThinFilm& film) : eta(eta), film(film) {}
  LobeSet lobes() const override { return MIRROR | REFRACTION; }
  void deltas(const Vec3f& wi, DeltaScatters& out) const override {
    const float cosine = std::min(std::abs(wi.z), 1.0f), rel = wi.z > 0 ? eta : 1 / eta;
    const DielectricFresnel bare = dielectricFresnel(cosine, rel);
    // Without absorption, both directions of a ray through the film have the same reflectance.
    const Rgb reflectance =
        bare.reflectance < 1 ? film.reflectance(wi.z > 0 ? cosine : bare.cosTransmitted, Rgb(eta)) : Rgb(1);
    if (!isBlack(reflectance)) out.add({{-wi.x, -wi.y, wi.z}, reflectance, 1, MIRROR});
    if (bare.reflectance < 1)
      out.add({{-wi.x / rel, -wi.y / rel, -std::copysign(bare.cosTransmitted, wi.z)},
               1 - reflectance,
               rel,
               REFRACTION});
  }
  bool lossless() const override { return true; }

 private:
  float eta;
  ThinFilm film;
};

/** Rough interface with a thin film on its outer side, without light that hits several facets. */
class FilmedRoughDielectric final : public RoughDielectricBsdf {
 public:
  FilmedRoughDielectric(const DielectricInterface& surface, const ThinFilm& film)
      : RoughDielectricBsdf(surface), film(film) {}
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    DielectricInterface::Facet f;
    if (!surface.facet(wi, wo, f)) return BLACK;
    return surface.valueOf(f, factor(wi, wo, f), wi, wo);
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    DielectricInterface::Facet f;
    if (!surface.facet(wi, wo, f)) return 0;
    return channelSum(factor(wi, wo, f)) / 3 *
           surface.pdf(wi, wo, wi.z * wo.z > 0 ? REFLECTION : TRANSMISSION);
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    const float side = wi.z > 0 ? 1.0f : -1.0f;
    const Vec3f m = surface.facets.sampleVisible(wi * side, u) * side;
    const float c = std::min(glm::dot(wi, m), 1.0f);
    if (!(c > 0)) return {};
    const DielectricFresnel bare = dielectricFresnel(c, surface.relative(wi));
    const float reflected =
        bare.reflectance < 1
            ? channelSum(film.reflectance(side > 0 ? c : bare.cosTransmitted, Rgb(surface.eta))) / 3
            : 1;
    return surface.sample(wi, u, 0, pick < reflected ? REFLECTION : TRANSMISSION);
  }

 private:
  /** Reflectance or transmittance of a facet. */
  Rgb factor(const Vec3f& wi, const Vec3f& wo, const DielectricInterface::Facet& f) const {
    const bool isReflection = wi.z * wo.z > 0;
    if (isReflection && f.fresnel >= 1) return Rgb(1);
    const Rgb reflectance = film.reflectance(f.cosAbove, Rgb(surface.eta));
    return isReflection ? reflectance : 1 - reflectance;
  }

  ThinFilm film;
};

/** Albedo of single scattering for light from one side (1: above, -1: below), as FacetLosses needs it. */
auto singleAlbedo(float eta, float side) {
  return [eta, side](const Vec3f& up, const Microfacets& facets, const Vec2f& u) {
    const DielectricInterface surface{eta, facets};
    float sum = 0;
    for (const Lobe lobe : {REFLECTION, TRANSMISSION})
      if (const auto step = surface.step({up.x, up.y, up.z * side}, u, lobe)) sum += step->weight;
    return sum;
  };
}

/** Energy that single scattering loses, for light from either side. */
struct InterfaceLosses {
  InterfaceLosses(float eta, const Roughness& roughness)
      : above(roughness, singleAlbedo(eta, 1)), below(roughness, singleAlbedo(eta, -1)) {
    constexpr int N = 256; // 1 - 2 ∫ F(μ) μ dμ
    for (int i = 0; i < N; ++i) {
      const float c = (static_cast<float>(i) + 0.5f) / N;
      transmittance += (1 - dielectricFresnel(c, eta).reflectance) * 2 * c / N;
    }
  }
  const FacetLosses& on(float z) const { return z > 0 ? above : below; }

  FacetLosses above, below;
  float transmittance = 0; ///< transmittance for diffuse light from above
};

/**
 * Single scattering plus light that hits several facets. On either side of the surface the lost energy leaves
 * with the angular shape of the loss there. The transmitted fraction follows the mean Fresnel transmittance,
 * limited by reciprocity between both ways up to the squares of the indices.
 */
class MultipleScatteringDielectric final : public RoughDielectricBsdf {
 public:
  MultipleScatteringDielectric(const DielectricInterface& surface, const InterfaceLosses& losses)
      : RoughDielectricBsdf(surface), losses(&losses), meanAbove(losses.above.meanLost(surface.facets)),
        meanBelow(losses.below.meanLost(surface.facets)) {
    const float k = losses.transmittance / std::max(meanAbove, meanBelow);
    fromAbove = k * meanBelow;
    fromBelow = k * meanAbove / square(surface.eta);
  }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    if (wi.z == 0 || wo.z == 0) return BLACK;
    const float mean = wo.z > 0 ? meanAbove : meanBelow;
    return RoughDielectricBsdf::value(wi, wo) + Rgb(share(wi, wo) * lost(wi) * lost(wo) / mean * INV_PI);
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    if (wi.z == 0 || wo.z == 0) return 0;
    const float more = lost(wi);
    return (1 - more) * surface.pdf(wi, wo) + more * share(wi, wo) * std::abs(wo.z) * INV_PI;
  }
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    const float more = lost(wi);
    if (pick >= more) return surface.sample(wi, u, std::min((pick - more) / (1 - more), ONE_MINUS_EPSILON));
    const Vec3f wo = cosineHemisphere(u);
    const bool through = pick < more * (wi.z > 0 ? fromAbove : fromBelow);
    return Vec3f(wo.x, wo.y, (wi.z > 0) != through ? wo.z : -wo.z);
  }
  bool lossless() const override { return true; }

 private:
  float lost(const Vec3f& w) const { return losses->on(w.z).lost(w, surface.facets); }
  /** Fraction of the lost energy from wi that leaves on the side of wo. */
  float share(const Vec3f& wi, const Vec3f& wo) const {
    const float through = wi.z > 0 ? fromAbove : fromBelow;
    return wi.z * wo.z > 0 ? 1 - through : through;
  }

  const InterfaceLosses* losses;
  float meanAbove, meanBelow;
  float fromAbove, fromBelow; ///< transmitted fractions of the lost energy
};

class Dielectric final : public Material {
 public:
  Dielectric(float eta, const Roughness& roughness, bool multiple, int rank,
             std::optional<DispersiveIndex> index, const ThinFilmParameters& film)
      : eta(eta), roughness(roughness), rank(rank), index(std::move(index)), film(film) {
    if (multiple && eta != 1 && !roughness.alwaysSmooth()) losses.emplace(eta, roughness);
  }
  const Bsdf* bsdfAt(const SurfacePoint& point, BsdfArena& arena) const override {
    const Microfacets facets = roughness.at(point);
    if (index && point.wavelength > 0 && facets.smooth())
      return arena.make<DispersiveBsdf>(*index, point.wavelength, point.isWhite);
    if (const ThinFilm here = film.at(point); here.exists()) {
      if (eta == 1 || facets.smooth()) return arena.make<FilmedDielectricBsdf>(eta, here);
      return arena.make<FilmedRoughDielectric>(DielectricInterface{eta, facets}, here);
    }
    const float relative = rank > 0 ? eta / point.indexOutside : eta;
    if (relative == 1 || facets.smooth()) return arena.make<DielectricBsdf>(relative);
    const DielectricInterface surface{relative, facets};
    if (!losses) return arena.make<SingleScatteringDielectric>(surface);
    return arena.make<MultipleScatteringDielectric>(surface, *losses);
  }
  LobeSet lobes() const override {
    // With a priority, the index outside varies; where it is equal there is no interface.
    const bool always = rank == 0 && eta != 1;
    return LobeSet(
        (index ? DISPERSIVE : NO_LOBE) | (always && roughness.neverSmooth() ? NO_LOBE : MIRROR | REFRACTION) |
        ((rank == 0 && eta == 1) || roughness.alwaysSmooth() ? NO_LOBE : NON_DELTA_LOBES | ANISOTROPIC));
  }
  int priority() const override { return rank; }
  float indexInside() const override { return eta; }

 private:
  float eta;
  Roughness roughness;
  int rank;                              ///< priority
  std::optional<InterfaceLosses> losses; ///< empty: single scattering only
  std::optional<DispersiveIndex> index;  ///< empty: no dispersion
  ThinFilmParameters film;
};

/** Wavelength dependence of the refractive index; empty where one index serves all wavelengths. */
std::optional<DispersiveIndex> dispersionOf(const Parameters& p, const Roughness& roughness, bool hasFilm) {
  if (!p.boolean("dispersion")) return {};
  SampledSpectrum spectrum = p.sampledSpectrum("eta");
  const char* source = "eta";
  if (p.hasValue("abbe")) {
    spectrum = cauchyIndex(p.spectrum("eta").g, p.real("abbe"));
    source = "abbe";
  }
  if (spectrum.values.empty()) return {};
  DispersiveIndex index(spectrum);
  if (index.isConstant()) return {};
  if (p.integer("priority") > 0 || !roughness.alwaysSmooth() || hasFilm) {
    p.warn(source, "no dispersion: it needs a smooth dielectric without a priority and without a film; this "
                   "one refracts all light like green light");
    return {};
  }
  return index;
}

} // namespace

void registerDielectric(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = {
      spectrumParameter(
          "eta", "1.5", SpectrumKind::UNBOUNDED,
          "refractive index inside over outside (the side of the normal); a spectrum is evaluated at green")
          .range(1e-3, 1e3)};
  addRoughnessParameters(parameters);
  addMultipleScatteringParameter(parameters);
  parameters.push_back(
      realParameter("abbe", "",
                    "Abbe number for dispersion by Cauchy's formula; eta is then the index in yellow light")
          .range(1, 1e6));
  parameters.push_back(booleanParameter("dispersion", "true",
                                        "dispersion: each colour has its own refractive index, if eta is a "
                                        "named glass or a spectrum, or abbe is given"));
  parameters.push_back(
      integerParameter("priority", "0",
                       "priority of a solid that overlaps others, such as water in a glass; 0: none. In an "
                       "overlap the highest priority defines the material (of equal ones the first in the "
                       "file), and the surfaces of the others are ignored. Materials with the same priority "
                       "and eta are one medium. eta is then the absolute index, not relative to the outside")
          .range(0, 1e6));
  addThinFilmParameters(parameters);
  plugIns.materials.add(
      {{.name = "dielectric",
        .summary =
            "Glass, water and other dielectrics: Fresnel reflection and refraction, blurred by roughness.",
        .parameters = parameters,
        .examples = {"\"float eta\" 1.5",
                     "\"float eta\" 0.75",
                     "\"float eta\" 1.33 \"integer priority\" 1",
                     "\"spectrum eta\" \"glass-BK7\"",
                     "\"float eta\" 1.6 \"float abbe\" 30",
                     "\"float roughness\" .002 \"bool remaproughness\" false",
                     "\"float roughness\" .1 \"bool remaproughness\" false",
                     "\"float roughness\" .4 \"float eta\" .7",
                     "\"float roughness\" 1 \"float eta\" 1.33",
                     "\"float uroughness\" .05 \"float vroughness\" .5",
                     "\"float roughness\" .2 \"float eta\" 2 \"string distribution\" \"beckmann\"",
                     "\"float roughness\" .3 \"bool multiscatter\" true",
                     "\"float roughness\" 1 \"float eta\" .7 \"bool multiscatter\" true",
                     "\"float roughness\" .5 \"float eta\" 2 \"bool multiscatter\" true "
                     "\"string distribution\" \"beckmann\"",
                     "\"float uroughness\" .05 \"float vroughness\" .5 \"bool multiscatter\" true",
                     "\"float eta\" 1 \"float thinfilm.thickness\" 500",
                     "\"float thinfilm.thickness\" 110 \"float thinfilm.eta\" 1.38",
                     "\"float eta\" .75 \"float thinfilm.thickness\" 300 \"float thinfilm.eta\" 1.6",
                     "\"float roughness\" .1 \"float thinfilm.thickness\" 250",
                     "\"float roughness\" .3 \"float eta\" .7 \"float thinfilm.thickness\" 400"}},
       [](const Parameters& p, const MaterialContext& c) {
         const Roughness roughness(p, c.textures);
         const bool multiple = wantsMultipleScattering(p, roughness);
         if (multiple && p.integer("priority") > 0)
           p.fail("multiscatter", "multiple scattering is not supported for dielectrics with a priority");
         const ThinFilmParameters film(p, c.textures);
         if (film.exists() && p.integer("priority") > 0)
           p.fail("thinfilm.thickness", "a film is not supported for dielectrics with a priority");
         if (film.exists() && multiple)
           p.fail("thinfilm.thickness", "a film is not supported for dielectrics with \"multiscatter\"");
         return std::make_unique<Dielectric>(static_cast<float>(p.spectrum("eta").g), roughness, multiple,
                                             p.integer("priority"), dispersionOf(p, roughness, film.exists()),
                                             film);
       }});
}

} // namespace recurse
