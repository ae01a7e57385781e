/** @file
 * Coated materials as pbrt-v4 means them: a dielectric layer, perhaps filled with a scattering medium, on a
 * diffuse or a metal base. Light between the two is followed by random walks (Pharr, Jakob, Humphreys,
 * "Physically Based Rendering", 4th edition, section 14.3; Guo, Hašan, Zhao 2018, "Position-Free Monte Carlo
 * Simulation for Arbitrary Layered BSDFs").
 *
 * The random numbers of a walk are hashed from the two directions, put in an order that does not depend on
 * which is which: value() is the same for the same arguments, and reciprocal. Its noise is that of a walk
 * from one pair of directions to the next, and averages out as theirs does. The two ways
 * in which a walk leaves a rough coat have weights that add up to one. In pbrt-v4 they add up to more where a
 * light's direction is evaluated (one density there is that of the way back), so that its rough coats come
 * out up to 2 % brighter; ours are as bright as the same coats built of two surfaces.
 *
 * A diffuse base forgets where light came from, so that a coat which scatters nothing inside needs no walk:
 * what it lets through, there and back, is tabulated, and what goes between base and coat is a geometric
 * series.
 *
 * What a smooth coat reflects at once is a delta lobe and exact. The sampling density is not that of the walk
 * but of a fitted mixture, in closed form.
 */
#include <bit>
#include <map>
#include <mutex>
#include <tuple>

#include "recurse/model/albedoTable.h"
#include "recurse/model/conductorOptics.h"
#include "recurse/model/dielectricInterface.h"
#include "recurse/model/plugIns.h"
#include "recurse/model/roughness.h"

namespace recurse {

namespace {

/** Uniform numbers that depend on two directions alone: PCG-RXS-M-XS (O'Neill 2014) on a hash of both. */
class WalkNumbers {
 public:
  WalkNumbers(const Vec3f& a, const Vec3f& b) : state(0) {
    for (const float x : {a.x, a.y, a.z, b.x, b.y, b.z})
      state = hashCombine(state, std::bit_cast<uint32_t>(x));
  }
  float next() {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return unitFloat(static_cast<uint32_t>(mixBits(state) >> 32));
  }
  Vec2f next2() {
    const float x = next();
    return {x, next()};
  }

 private:
  uint64_t state;
};

/** What lies below the coat. All directions that it is given point up, into the coat. */
struct DiffuseBase {
  static constexpr bool CAN_BE_SMOOTH = false;
  Rgb reflectance;

  bool smooth() const { return false; }
  bool anisotropic() const { return false; }
  Rgb value(const Vec3f&, const Vec3f&) const { return reflectance * INV_PI; }
  float pdf(const Vec3f&, const Vec3f& wo) const { return wo.z * INV_PI; }
  /** wo and f cos / pdf. */
  bool step(const Vec3f&, const Vec2f& u, Vec3f& wo, Rgb& weight) const {
    wo = cosineHemisphere(u);
    weight = reflectance;
    return wo.z > 0;
  }
  /** Reflectance for light that comes from w, nearly. */
  Rgb albedo(const Vec3f&) const { return reflectance; }
};

struct ConductorBase {
  static constexpr bool CAN_BE_SMOOTH = true;
  ConductorOptics optics;
  Microfacets facets;

  bool smooth() const { return facets.smooth(); }
  bool anisotropic() const { return !smooth() && facets.anisotropic(); }
  Rgb value(const Vec3f& wi, const Vec3f& wo) const {
    if (smooth()) return BLACK;
    const Vec3f m = halfVector(wi, wo);
    return optics.reflectance(absDot(wi, m)) * facets.reflection(wi, wo, m);
  }
  float pdf(const Vec3f& wi, const Vec3f& wo) const {
    return smooth() ? 0 : facets.reflectionPdf(wi, halfVector(wi, wo));
  }
  bool step(const Vec3f& wi, const Vec2f& u, Vec3f& wo, Rgb& weight) const {
    if (smooth()) {
      wo = {-wi.x, -wi.y, wi.z};
      weight = optics.reflectance(wi.z);
      return true;
    }
    wo = glm::normalize(mirrored(wi, facets.sampleVisible(wi, u)));
    if (!(wo.z > 0)) return false;
    const float p = pdf(wi, wo);
    if (!(p > 0)) return false;
    weight = value(wi, wo) * (wo.z / p);
    return true;
  }
  Rgb albedo(const Vec3f& w) const { return optics.reflectance(w.z); }
};

/** The coat's inside: as in pbrt-v4 its extinction coefficient is 1, also where nothing is scattered. */
struct Medium {
  float thickness = 0.01f;
  Rgb albedo{0};
  float g = 0;
  int maxDepth = 10, samples = 1;
};

float slabTransmittance(float distance, float cosine) { return std::exp(-std::abs(distance / cosine)); }

/** What a clear coat does with light between its outside and a diffuse base. */
class ClearCoat {
 public:
  ClearCoat(float eta, MicrofacetKind kind, float leastAlpha, float mostAlpha, float thickness)
      : thickness(thickness), leastAlpha(leastAlpha), mostAlpha(mostAlpha) {
    const auto coatOf = [=](float alpha) { return DielectricInterface{eta, {kind, Vec2f(alpha)}}; };
    transmitted = AlbedoTable(leastAlpha, mostAlpha, [&](const Vec3f& wi, float alpha, const Vec2f& u) {
      const auto in = coatOf(alpha).step(wi, u, TRANSMISSION);
      return in && in->wo.z != 0 ? in->weight * slabTransmittance(thickness, in->wo.z) : 0;
    });
    const int rows = mostAlpha > leastAlpha ? 20 : 1;
    for (int row = 0; row < rows; ++row)
      returned.push_back(returnedBy(coatOf(leastAlpha + (mostAlpha - leastAlpha) * static_cast<float>(row) /
                                                            std::max(rows - 1.0f, 1.0f))));
  }

  /** Of light from outside, what comes to the base. */
  float transmittance(const DielectricInterface& coat, float cosine) const {
    if (!coat.facets.smooth()) return transmitted.at(cosine, coat.facets.roughness().x);
    const DielectricFresnel f = dielectricFresnel(std::min(cosine, 1.0f), coat.eta);
    return f.reflectance < 1 ? (1 - f.reflectance) * slabTransmittance(thickness, f.cosTransmitted) : 0;
  }
  /** Of light that the base scatters, what comes back to it. */
  float reflectance(const DielectricInterface& coat) const {
    const float x =
        std::clamp((coat.facets.roughness().x - leastAlpha) / (mostAlpha - leastAlpha), 0.0f, 1.0f) *
        static_cast<float>(returned.size() - 1);
    if (returned.size() == 1) return returned[0];
    const auto row = std::min(static_cast<size_t>(x), returned.size() - 2);
    return glm::mix(returned[row], returned[row + 1], x - static_cast<float>(row));
  }

  /** Coats that are alike share what is tabulated. */
  static std::shared_ptr<const ClearCoat> make(float eta, MicrofacetKind kind, float leastAlpha,
                                               float mostAlpha, float thickness) {
    static std::mutex one;
    static std::map<std::tuple<float, MicrofacetKind, float, float, float>, std::weak_ptr<const ClearCoat>>
        made;
    const std::lock_guard guard(one);
    std::weak_ptr<const ClearCoat>& known = made[{eta, kind, leastAlpha, mostAlpha, thickness}];
    std::shared_ptr<const ClearCoat> coat = known.lock();
    if (!coat) {
      coat = std::make_shared<const ClearCoat>(eta, kind, leastAlpha, mostAlpha, thickness);
      known = coat;
    }
    return coat;
  }

 private:
  /** The mean over directions of diffuse light, by points that fill a cube evenly: multiples of powers of the
   * root of x⁴ = x + 1, as those of the golden ratio fill an interval. */
  float returnedBy(const DielectricInterface& coat) const {
    constexpr int COUNT = 1 << 15;
    const Vec3d step(0.8191725133961645, 0.6710436067037893, 0.5497004779019703);
    double sum = 0;
    for (int i = 0; i < COUNT; ++i) {
      const Vec3f u(glm::fract((double(i) + 0.5) * step));
      const float cosine = std::sqrt(std::max(u.x, 1e-6f));
      const auto back = coat.step({std::sqrt(1 - square(cosine)), 0, -cosine}, {u.y, u.z}, REFLECTION);
      if (back && back->wo.z != 0)
        sum += double(back->weight * slabTransmittance(thickness, cosine) *
                      slabTransmittance(thickness, back->wo.z));
    }
    return static_cast<float>(sum / COUNT);
  }

  float thickness, leastAlpha, mostAlpha;
  AlbedoTable transmitted;
  std::vector<float> returned; ///< over equal steps of alpha
};

/** Henyey and Greenstein's phase function of the angle between the ways before and after; 1941. */
float phase(float cosine, float g) {
  const float d = 1 + g * g - 2 * g * cosine;
  return (1 - g * g) / (4 * PI * d * std::sqrt(std::max(d, 1e-20f)));
}

Vec3f samplePhase(const Vec3f& way, float g, const Vec2f& u) {
  float cosine = 1 - 2 * u.x;
  if (std::abs(g) > 1e-3f) {
    const float s = (1 - g * g) / (1 + g - 2 * g * u.x);
    cosine = std::clamp((1 + g * g - s * s) / (2 * g), -1.0f, 1.0f);
  }
  const float sine = std::sqrt(std::max(0.0f, 1 - square(cosine))), phi = 2 * PI * u.y;
  return glm::normalize(Frame(way).toWorld({sine * std::cos(phi), sine * std::sin(phi), cosine}));
}

template <class Base> class CoatedBsdf final : public Bsdf {
 public:
  /** `clear` is null where light has to be followed through the coat. */
  CoatedBsdf(const DielectricInterface& coat, const Base& base, const Medium& medium,
             const ClearCoat* clear = nullptr)
      : coat(coat), base(base), medium(medium), clear(clear) {
    smoothCoat = coat.facets.smooth();
    allSmooth = smoothCoat && base.smooth() && isBlack(medium.albedo);
    if constexpr (Base::CAN_BE_SMOOTH) {
      // Facets outside that would bend light as the base does below the coat: a base's tilt turns light by
      // eta times as much outside, and a coat's tilt by (eta - 1)/2 of a mirror's, on the way in and out.
      const Vec2f b = base.smooth() ? Vec2f(0) : base.facets.roughness() * coat.eta;
      const Vec2f c = smoothCoat ? Vec2f(0) : coat.facets.roughness() * ((coat.eta - 1) * 0.7071f);
      fitted = Microfacets(MicrofacetKind::TROWBRIDGE_REITZ,
                           glm::clamp(glm::sqrt(b * b + c * c), Vec2f(0.01f), Vec2f(1)));
    }
  }

  LobeSet lobes() const override {
    LobeSet all = allSmooth ? NO_LOBE : REFLECTION;
    if (smoothCoat) all |= MIRROR;
    if ((!smoothCoat && coat.facets.anisotropic()) || base.anisotropic()) all |= ANISOTROPIC;
    return all;
  }

  Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
    if (!(wi.z * wo.z > 0) || allSmooth) return BLACK;
    Vec3f a = up(wi), b = up(wo); // both sides are coated alike
    if (b.z < a.z || (b.z == a.z && (b.x < a.x || (b.x == a.x && b.y < a.y)))) std::swap(a, b);
    Rgb sum(0);
    if (clear) {
      sum = throughClear(a, b);
    } else {
      WalkNumbers numbers(a, b);
      for (int i = 0; i < medium.samples; ++i) walk(a, b, numbers, sum);
      sum /= static_cast<float>(medium.samples);
    }
    if (!smoothCoat) sum += Rgb(coat.value(a, b));
    return sum;
  }

  float pdf(const Vec3f& wi, const Vec3f& wo) const override {
    if (!(wi.z * wo.z > 0) || allSmooth) return 0;
    const Vec3f a = up(wi), b = up(wo);
    const Shares s = shares(a);
    float sum = s.cosine * b.z * INV_PI;
    if (s.coat > 0) sum += s.coat * coat.facets.reflectionPdf(a, halfVector(a, b));
    if (s.base > 0) sum += s.base * fitted.reflectionPdf(a, halfVector(a, b));
    return sum;
  }

  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const override {
    if (allSmooth) return {};
    const Vec3f a = up(wi);
    const Shares s = shares(a);
    Vec3f wo;
    if (pick < s.coat)
      wo = mirrored(a, coat.facets.sampleVisible(a, u));
    else if (pick < s.coat + s.base)
      wo = mirrored(a, fitted.sampleVisible(a, u));
    else
      wo = cosineHemisphere(u);
    if (!(wo.z > 0)) return {};
    wo = glm::normalize(wo);
    return wi.z < 0 ? Vec3f(wo.x, wo.y, -wo.z) : wo;
  }

  void deltas(const Vec3f& wi, DeltaScatters& out) const override {
    if (!smoothCoat) return;
    const Vec3f a = up(wi);
    const DielectricFresnel f = dielectricFresnel(std::min(a.z, 1.0f), coat.eta);
    Rgb weight(f.reflectance);
    if (allSmooth && f.reflectance < 1) {
      // All reflections between two mirrors that the depth allows.
      const Rgb once = base.albedo({0, 0, f.cosTransmitted}) *
                       square(slabTransmittance(medium.thickness, f.cosTransmitted));
      Rgb path = once * square(1 - f.reflectance);
      for (int depth = 2; depth < medium.maxDepth; depth += 2) {
        weight += path;
        path *= once * f.reflectance;
      }
    }
    out.add({{-wi.x, -wi.y, wi.z}, weight, 1, MIRROR});
  }

  Rgb albedo(const Vec3f& wi) const override {
    if (allSmooth) return BLACK;
    const float r = coatReflectance(up(wi));
    const Rgb below = base.albedo({0, 0, 1});
    // What is reflected inside comes back to the base: about 0.6 of diffuse light at eta 1.5.
    const Rgb inside = below / (0.3f * (1 - below) + 1);
    return min(inside * (1 - r) + Rgb(smoothCoat ? 0.0f : r) + medium.albedo * 0.1f, Rgb(1));
  }

 private:
  struct Shares {
    float coat = 0, base = 0, cosine = 0; ///< chances of the parts of the sampling density
  };

  static Vec3f up(const Vec3f& w) { return {w.x, w.y, std::abs(w.z)}; }
  float coatReflectance(const Vec3f& a) const {
    return dielectricFresnel(std::min(a.z, 1.0f), coat.eta).reflectance;
  }
  Shares shares(const Vec3f& a) const {
    const float r = coatReflectance(a),
                below = (1 - r) * std::max(maxComponent(base.albedo({0, 0, 1})), 0.05f);
    Shares s;
    s.coat = smoothCoat ? 0 : r / (r + below);
    const float rest = 1 - s.coat;
    if (Base::CAN_BE_SMOOTH) s.base = 0.8f * rest;
    s.cosine = rest - s.base;
    return s;
  }
  static float heuristic(float p, float q) { return p * p / (p * p + q * q); }

  /** As the walks' mean: each visit to the base scatters what has come, and sends part of it on. */
  Rgb throughClear(const Vec3f& a, const Vec3f& b) const {
    const Rgb below = base.albedo(a);
    const Rgb again = below * clear->reflectance(coat);
    Rgb visits(0), visit(1);
    for (int depth = 0; depth < medium.maxDepth; depth += 2) {
      visits += visit;
      visit *= again;
    }
    const float through = clear->transmittance(coat, a.z) * clear->transmittance(coat, b.z);
    return below * visits * (INV_PI * through / square(coat.eta));
  }

  /** Adds one walk's estimate of what the inside of the coat scatters from a to b, both up. */
  void walk(const Vec3f& a, const Vec3f& b, WalkNumbers& numbers, Rgb& sum) const {
    const auto in = coat.step(a, numbers.next2(), TRANSMISSION);
    const auto out = coat.step(b, numbers.next2(), TRANSMISSION); // walked from its end
    if (!in || !out || in->wo.z == 0 || out->wo.z == 0) return;
    const Vec3f exit = -out->wo; // the way up that the end comes from
    // Walked backwards, flux would have come the other way: 1/eta².
    const float exitCosine = exit.z, exitWeight = out->weight / square(coat.eta);
    const float exitPdf = smoothCoat ? 0 : coat.pdf(b, out->wo, TRANSMISSION);
    Rgb beta(in->weight);
    Vec3f way = in->wo; // where the light goes
    float z = medium.thickness;
    bool atTop = true;
    for (int depth = 0; depth < medium.maxDepth; ++depth) {
      if (depth > 3 && maxComponent(beta) < 0.25f) {
        const float survival = maxComponent(beta);
        if (!(numbers.next() < survival)) return;
        beta /= survival;
      }
      if (way.z == 0) return;
      if (isBlack(medium.albedo)) {
        beta *= slabTransmittance(medium.thickness, way.z);
        atTop = !atTop;
      } else {
        const float dz = -std::log(1 - numbers.next()) * std::abs(way.z);
        const float next = way.z > 0 ? z + dz : z - dz;
        if (next > 0 && next < medium.thickness) {
          const float toTop = medium.thickness - next;
          const float p = phase(glm::dot(way, exit), medium.g);
          const float shared = smoothCoat ? 1 : heuristic(exitPdf, p);
          sum += beta * medium.albedo *
                 (p * shared * slabTransmittance(toTop, exit.z) * exitWeight / exitCosine);
          way = samplePhase(way, medium.g, numbers.next2());
          beta *= medium.albedo;
          z = next;
          if (!smoothCoat && way.z > 0) leave(way, b, toTop, phase(glm::dot(way, exit), medium.g), beta, sum);
          continue;
        }
        z = next <= 0 ? 0 : medium.thickness;
        atTop = next > 0;
      }
      if (atTop) {
        const auto back = coat.step(-way, numbers.next2(), REFLECTION);
        if (!back) return;
        beta *= back->weight;
        way = back->wo;
      } else {
        const Vec3f from = -way;
        if (!base.smooth()) {
          const float shared = smoothCoat ? 1 : heuristic(exitPdf, base.pdf(from, exit));
          sum += beta * base.value(from, exit) *
                 (shared * slabTransmittance(medium.thickness, exit.z) * exitWeight);
        }
        Rgb weight;
        if (!base.step(from, numbers.next2(), way, weight)) return;
        beta *= weight;
        z = 0;
        if (!smoothCoat) leave(way, b, medium.thickness, base.smooth() ? -1 : base.pdf(from, way), beta, sum);
      }
      if (isBlack(beta)) return;
    }
  }

  /** Light that went `way` with density pdf (below 0: a delta) goes out to b by the coat's own lobe. */
  void leave(const Vec3f& way, const Vec3f& b, float distance, float pdf, const Rgb& beta, Rgb& sum) const {
    const float f = coat.value(-way, b);
    if (!(f > 0)) return;
    // Had b's own sample gone this way, this would have been its density.
    const float shared = pdf < 0 ? 1 : heuristic(pdf, coat.pdf(b, -way, TRANSMISSION));
    sum += beta * (f * shared * slabTransmittance(distance, way.z));
  }

  DielectricInterface coat;
  Base base;
  Medium medium;
  const ClearCoat* clear;
  Microfacets fitted;
  bool smoothCoat = false, allSmooth = false;
};

/** The coat's parameters; `prefix` comes before those of its surface. */
struct CoatParameters {
  CoatParameters(const Parameters& p, const TextureLookup& textures, const std::string& prefix)
      : roughness(p, textures, prefix), thickness(textures.real(p, "thickness")), g(textures.real(p, "g")),
        albedo(textures.rgb(p, "albedo")), eta(static_cast<float>(p.spectrum(prefix + "eta").g)),
        maxDepth(p.integer("maxdepth")), samples(p.integer("nsamples")) {}

  static void declare(std::vector<ParameterSpec>& parameters, const std::string& prefix) {
    parameters.push_back(spectrumParameter(prefix + "eta", "1.5", SpectrumKind::UNBOUNDED,
                                           "refractive index of the coat; of a spectrum, the value for green")
                             .range(1, 1e3));
    addRoughnessParameters(parameters, prefix);
    parameters.push_back(realParameter("thickness", "0.01",
                                       "of the coat [mean free paths of its medium, which absorbs what it "
                                       "does not scatter]")
                             .range(0, 1e6)
                             .withTexture());
    parameters.push_back(
        spectrumParameter("albedo", "0", SpectrumKind::ALBEDO, "of the medium inside the coat")
            .withTexture());
    parameters.push_back(
        realParameter("g", "0", "mean cosine of the medium's scattering").range(-0.999, 0.999).withTexture());
    parameters.push_back(
        integerParameter("maxdepth", "10", "most meetings of a walk with the coat's two faces")
            .range(1, 1e6));
    parameters.push_back(
        integerParameter("nsamples", "1", "walks for each evaluation: fewer are noisier").range(1, 1e6));
  }

  DielectricInterface surface(const SurfacePoint& point) const {
    if (eta == 1) return {eta, {}}; // no surface, which has no roughness
    return {eta, roughness.at(point)};
  }
  Medium medium(const SurfacePoint& point) const {
    return {thickness.at(point).r, albedo.at(point), g.at(point).r, maxDepth, samples};
  }
  static constexpr float MAX_TABULATED = 1; ///< alpha
  /** Null where the coat's medium scatters, or a table would need more than a roughness to go by. */
  std::shared_ptr<const ClearCoat> clear() const {
    if (albedo.texture || !isBlack(albedo.constant) || thickness.texture || roughness.anisotropic())
      return {};
    float least = Microfacets::SMOOTH_BELOW, most = MAX_TABULATED;
    if (!roughness.textured()) {
      const float alpha = surface(SurfacePoint{}).facets.roughness().x;
      if (alpha > MAX_TABULATED) return {};
      least = most = alpha;
    }
    return ClearCoat::make(eta, roughness.kind, least, most, thickness.constant.r);
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
    optics.eta /= coat.eta; // the metal lies below the coat, not below air
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
                          .summary = "A metal below a dielectric coat, both smooth or rough.",
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
