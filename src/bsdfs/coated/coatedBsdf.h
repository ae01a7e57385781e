/** @file
 * Dielectric coat on a base. Random walks follow the light between the two: doc-files/notes/coats.md.
 */
#pragma once

#include <bit>

#include "bsdfs/coated/clearCoat.h"
#include "bsdfs/microfacet/conductorOptics.h"
#include "recurse/model/bsdf/bsdf.h"

namespace recurse {

/** Uniform pseudorandom numbers seeded by two directions: PCG-RXS-M-XS (O'Neill 2014) on a hash of both. */
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

/** Diffuse base below the coat. All directions that a base is given point up, into the coat. */
struct DiffuseBase {
  static constexpr bool CAN_BE_SMOOTH = false;
  Rgb reflectance;

  bool smooth() const { return false; }
  bool anisotropic() const { return false; }
  Rgb value(const Vec3f&, const Vec3f&) const { return reflectance * INV_PI; }
  float pdf(const Vec3f&, const Vec3f& wo) const { return wo.z * INV_PI; }
  /** Samples wo; `weight` is f cos / pdf. */
  bool step(const Vec3f&, const Vec2f& u, Vec3f& wo, Rgb& weight) const {
    wo = cosineHemisphere(u);
    weight = reflectance;
    return wo.z > 0;
  }
  /** Approximate reflectance for light from w. */
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

/** Medium inside the coat. As in pbrt-v4 its extinction coefficient is 1, even where its albedo is 0. */
struct CoatMedium {
  float thickness = 0.01f;
  Rgb albedo{0};
  float g = 0;
  int maxDepth = 10, samples = 1;
};

/** Henyey-Greenstein phase function (1941) [1/sr]; `cosine` of the directions before and after scattering. */
inline float phaseValue(float cosine, float g) {
  const float d = 1 + g * g - 2 * g * cosine;
  return (1 - g * g) / (4 * PI * d * std::sqrt(std::max(d, 1e-20f)));
}

inline Vec3f samplePhase(const Vec3f& way, float g, const Vec2f& u) {
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
  /** `clear` is null where random walks must follow the light through the coat. */
  CoatedBsdf(const DielectricInterface& coat, const Base& base, const CoatMedium& medium,
             const ClearCoat* clear = nullptr)
      : coat(coat), base(base), medium(medium), clear(clear) {
    smoothCoat = coat.facets.smooth();
    allSmooth = smoothCoat && base.smooth() && isBlack(medium.albedo);
    if (clear) scattered = scatteredByBase();
    if constexpr (Base::CAN_BE_SMOOTH) {
      // Roughness of one equivalent facet outside the coat: a tilt of the base is magnified by eta, one of
      // the coat by (eta - 1) / 2 per crossing.
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
      const float in =
          known(transmitted, std::abs(wi.z), [&](float z) { return clear->transmittance(coat, z); });
      sum = scattered * (in * clear->transmittance(coat, std::abs(wo.z)));
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
    const Shares s = known(sharesAt, a.z, [&](float) { return shares(a); });
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
      // Sum over the reflections between the two mirrors, up to the maximum depth.
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
    // Internal reflection returns about 0.6 of the diffuse light to the base at eta 1.5.
    const Rgb inside = below / (0.3f * (1 - below) + 1);
    return min(inside * (1 - r) + Rgb(smoothCoat ? 0.0f : r) + medium.albedo * 0.1f, Rgb(1));
  }

 private:
  struct Shares {
    float coat = 0, base = 0, cosine = 0; ///< probabilities of the components of the sampling density
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

  /** Last value of a function of a cosine. It is often reused, because many photons are evaluated for one
   * direction. */
  template <class T> struct AtCosine {
    float cosine = -1;
    T value{};
  };
  template <class T, class Compute>
  static const T& known(AtCosine<T>& last, float cosine, const Compute& compute) {
    if (last.cosine != cosine) last = {cosine, compute(cosine)};
    return last.value;
  }

  /** Expected value of the walks for light that has reached the base: each visit scatters it, and the coat
   * returns part of it. The product with the transmittances of both directions is the BRDF [1/sr]. */
  Rgb scatteredByBase() const {
    const Rgb below = base.albedo({0, 0, 1});
    const Rgb again = below * clear->reflectance(coat);
    Rgb visits(0), visit(1);
    for (int depth = 0; depth < medium.maxDepth; depth += 2) {
      visits += visit;
      visit *= again;
    }
    return below * visits * (INV_PI / square(coat.eta));
  }

  /** Exit of a walk: its directions, weight and density. */
  struct Exit {
    Vec3f direction; ///< up, inside the coat
    Vec3f outside;   ///< up, outside the coat
    float weight, pdf;
  };
  struct Walk {
    Vec3f way; ///< direction of travel of the light
    Rgb beta;
    float z; ///< height above the base, 0 at the base
    bool atTop = true;
  };

  /** Adds the estimate of one walk for the light that the coat's inside scatters from a to b, both up. */
  void walk(const Vec3f& a, const Vec3f& b, WalkNumbers& numbers, Rgb& sum) const {
    const auto in = coat.step(a, numbers.next2(), TRANSMISSION);
    const auto out = coat.step(b, numbers.next2(), TRANSMISSION); // sampled from the exit
    if (!in || !out || in->wo.z == 0 || out->wo.z == 0) return;
    // The exit is sampled in reverse; flux, which travels the opposite way, has the factor 1/eta².
    const Exit exit{-out->wo, b, out->weight / square(coat.eta),
                    smoothCoat ? 0 : coat.pdf(b, out->wo, TRANSMISSION)};
    Walk w{in->wo, Rgb(in->weight), medium.thickness};
    for (int depth = 0; depth < medium.maxDepth; ++depth) {
      if (depth > 3 && maxComponent(w.beta) < 0.25f) {
        const float survival = maxComponent(w.beta);
        if (!(numbers.next() < survival)) return;
        w.beta /= survival;
      }
      if (w.way.z == 0) return;
      if (scatterInside(w, exit, numbers, sum)) continue;
      if (!(w.atTop ? reflectAtCoat(w, numbers) : scatterAtBase(w, exit, numbers, sum))) return;
      if (isBlack(w.beta)) return;
    }
  }

  /** Crosses the medium to the opposite face. True where the light scatters before it. */
  bool scatterInside(Walk& w, const Exit& exit, WalkNumbers& numbers, Rgb& sum) const {
    if (isBlack(medium.albedo)) {
      w.beta *= slabTransmittance(medium.thickness, w.way.z);
      w.atTop = !w.atTop;
      return false;
    }
    const float dz = -std::log(1 - numbers.next()) * std::abs(w.way.z);
    const float next = w.way.z > 0 ? w.z + dz : w.z - dz;
    if (!(next > 0 && next < medium.thickness)) {
      w.z = next <= 0 ? 0 : medium.thickness;
      w.atTop = next > 0;
      return false;
    }
    const float toTop = medium.thickness - next;
    const float p = phaseValue(glm::dot(w.way, exit.direction), medium.g);
    const float shared = smoothCoat ? 1 : heuristic(exit.pdf, p);
    sum += w.beta * medium.albedo *
           (p * shared * slabTransmittance(toTop, exit.direction.z) * exit.weight / exit.direction.z);
    w.way = samplePhase(w.way, medium.g, numbers.next2());
    w.beta *= medium.albedo;
    w.z = next;
    if (!smoothCoat && w.way.z > 0)
      leave(w, exit.outside, toTop, phaseValue(glm::dot(w.way, exit.direction), medium.g), sum);
    return true;
  }

  bool reflectAtCoat(Walk& w, WalkNumbers& numbers) const {
    const auto back = coat.step(-w.way, numbers.next2(), REFLECTION);
    if (!back) return false;
    w.beta *= back->weight;
    w.way = back->wo;
    return true;
  }

  bool scatterAtBase(Walk& w, const Exit& exit, WalkNumbers& numbers, Rgb& sum) const {
    const Vec3f from = -w.way;
    if (!base.smooth()) {
      const float shared = smoothCoat ? 1 : heuristic(exit.pdf, base.pdf(from, exit.direction));
      sum += w.beta * base.value(from, exit.direction) *
             (shared * slabTransmittance(medium.thickness, exit.direction.z) * exit.weight);
    }
    Rgb weight;
    if (!base.step(from, numbers.next2(), w.way, weight)) return false;
    w.beta *= weight;
    w.z = 0;
    if (!smoothCoat)
      leave(w, exit.outside, medium.thickness, base.smooth() ? -1 : base.pdf(from, w.way), sum);
    return true;
  }

  /** Adds transmission to b through the rough coat, for a direction of density pdf [1/sr] (< 0: a delta). */
  void leave(const Walk& w, const Vec3f& b, float distance, float pdf, Rgb& sum) const {
    const float f = coat.value(-w.way, b);
    if (!(f > 0)) return;
    // MIS with the sample of b, which has this density for the same direction.
    const float shared = pdf < 0 ? 1 : heuristic(pdf, coat.pdf(b, -w.way, TRANSMISSION));
    sum += w.beta * (f * shared * slabTransmittance(distance, w.way.z));
  }

  DielectricInterface coat;
  Base base;
  CoatMedium medium;
  const ClearCoat* clear;
  Rgb scattered{0}; ///< see scatteredByBase()
  Microfacets fitted;
  mutable AtCosine<float> transmitted; ///< transmittance of a clear coat
  mutable AtCosine<Shares> sharesAt;
  bool smoothCoat = false, allSmooth = false;
};

} // namespace recurse
