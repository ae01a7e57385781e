/** @file
 * Scattering at a surface point: the single place that converts the local functions of a BSDF plug-in for the
 * forward and the backward pass. It alone applies the 1/η² scaling of radiance at delta refraction, the
 * correction for shading normals in the forward pass (Veach 1997, equation 5.19), and the test for light
 * leaks through the geometric surface.
 */
#pragma once

#include "recurse/core/sampling/sampler.h"
#include "recurse/core/sampling/sampling.h"
#include "recurse/model/bsdf/bsdf.h"
#include "recurse/model/bsdf/directionGuide.h"

namespace recurse {

/** Quantity transported along the walk. */
enum class Transport {
  RADIANCE, ///< backward, from the camera
  FLUX,     ///< forward, from the lights
};

/** Sampled step of a walk. */
struct Scatter {
  Vec3f direction; ///< unit, world
  Rgb weight{
      0}; ///< factor of the throughput: BSDF · cosine / density, including the factors of the transport mode
  float pdf = 0; ///< density [1/sr], including the probability of the chosen lobe; for a delta lobe, the
                 ///< probability of choosing it
  Lobe lobe = NO_LOBE;
  float eta = 1; ///< refractive index on the side of the new direction over the index on the previous side
  /** Albedo over the weight, 1 without a guide. A guided weight is low where radiance is high; times this
   * factor it is the mean weight of BSDF sampling, on which Russian roulette is based. */
  float rouletteScale = 1;

  bool specular() const { return (lobe & DELTA_LOBES) != 0; }
};

/** BSDF at a surface point, with both normals. Directions are unit, in the world, and point away from the
 * surface: wi to the previous vertex of the walk, wo to the next one. */
class ScatteringPoint {
 public:
  /** The BSDF must outlive it. */
  ScatteringPoint(const Bsdf& bsdf, const SurfacePoint& point)
      : bsdf(bsdf), frame(point.shadingNormal), geometricNormal(point.geometricNormal), lobeSet(bsdf.lobes()),
        curve(point.curve) {
    if (lobeSet & ANISOTROPIC) frame = Frame(point.shadingNormal, point.dpdu);
    if (lobeSet & LAMBERTIAN) constant = bsdf.value({0, 0, 1}, {0, 0, 1});
  }

  /** Mixes a guide, which must outlive it, into the sampling of radiance walks, not of photons. Null: none.
   * No effect unless isGuidable(). */
  void follow(const DirectionGuide* newGuide) { guide = isGuidable() ? newGuide : nullptr; }
  /** Whether a guide can be used: guides cover the directions on one side of a surface only. */
  bool isGuidable() const { return hasNonDelta() && !(lobeSet & (TRANSMISSION | FIBRE)); }

  LobeSet lobes() const { return lobeSet; }
  bool hasNonDelta() const { return (lobeSet & NON_DELTA_LOBES) != 0; }
  /** Whether photons are stored here for density estimates; otherwise paths account for their light. */
  bool keepsPhotons() const {
    return hasNonDelta() && curve == SurfacePoint::Curve::NONE && !(lobeSet & FIBRE);
  }
  bool hasDelta() const { return (lobeSet & DELTA_LOBES) != 0; }

  /** Non-delta BSDF without cosine [1/sr], for radiance that arrives from wo and leaves towards wi: the
   * factor of a photon's power in density estimates. */
  Rgb value(const Vec3f& wi, const Vec3f& wo) const {
    if (leaks(wi, wo)) return BLACK;
    if (lobeSet & LAMBERTIAN) return glm::dot(wi, frame.z) * glm::dot(wo, frame.z) > 0 ? constant : BLACK;
    return bsdf.value(frame.toLocal(wo), frame.toLocal(wi));
  }

  /** Non-delta BSDF times the cosine of `light`, for radiance that arrives from `light` and leaves towards
   * `eye`. */
  Rgb evaluate(const Vec3f& eye, const Vec3f& light) const {
    return value(eye, light) * absDot(light, frame.z);
  }

  /** Non-delta BSDF times the cosine of `wo` and the correction for shading normals, for a photon that
   * arrives from `wi` and leaves towards `wo`. */
  Rgb evaluateFlux(const Vec3f& wi, const Vec3f& wo) const {
    const Vec3f localI = frame.toLocal(wi), localO = frame.toLocal(wo);
    const Rgb f = lobeSet & LAMBERTIAN ? value(wo, wi) : leaks(wi, wo) ? BLACK : fluxValue(localI, localO);
    return f * (std::abs(localO.z) * shadingNormalFactor(wi, localI, wo, localO));
  }

  /** Refractive index on the side of wo over the index on the side of wi, for the non-delta lobes. */
  float relativeIndex(const Vec3f& wi, const Vec3f& wo) const {
    if (!(lobeSet & TRANSMISSION)) return 1;
    const float cosI = glm::dot(wi, frame.z);
    if (!(cosI * glm::dot(wo, frame.z) < 0)) return 1;
    return cosI > 0 ? bsdf.eta() : 1 / bsdf.eta();
  }

  /** Density of wo in scatter() [1/sr]; `allowed` includes the non-delta lobes. */
  float pdf(const Vec3f& wi, const Vec3f& wo, LobeSet allowed = ALL_LOBES,
            Transport transport = Transport::RADIANCE) const {
    if (!(lobeSet & allowed & DELTA_LOBES)) return pdfNonDelta(wi, wo, transport);
    const Vec3f local = frame.toLocal(wi);
    return pdfNonDelta(wi, wo, transport) * nonDeltaProbability(local);
  }
  /** Density of wo in scatterNonDelta(), which samples only the non-delta lobes [1/sr]. */
  float pdfNonDelta(const Vec3f& wi, const Vec3f& wo, Transport transport = Transport::RADIANCE) const {
    const float byBsdf = pdfBsdf(wi, wo);
    return guide && transport == Transport::RADIANCE ? guide->mixturePdf(byBsdf, wo) : byBsdf;
  }
  /** Density of BSDF sampling alone, without the guide [1/sr]. */
  float pdfBsdf(const Vec3f& wi, const Vec3f& wo) const {
    if (lobeSet & LAMBERTIAN) {
      const float cosI = glm::dot(wi, frame.z), cosO = glm::dot(wo, frame.z);
      return cosI * cosO > 0 ? std::abs(cosO) * INV_PI : 0;
    }
    return bsdf.pdf(frame.toLocal(wi), frame.toLocal(wo));
  }

  /** Chooses an allowed lobe in proportion to its albedo or weight (largest channel), and samples a step.
   * `allowed`: both delta lobes or none, and both non-delta lobes or none. Empty: absorbed. */
  std::optional<Scatter> scatter(const Vec3f& wi, Transport transport, Sampler& sampler,
                                 LobeSet allowed = ALL_LOBES) const {
    allowed &= lobeSet;
    if (!(allowed & DELTA_LOBES)) {
      if (!(allowed & NON_DELTA_LOBES)) return {};
      return scatterNonDelta(wi, transport, sampler);
    }
    const Vec3f local = frame.toLocal(wi);
    DeltaScatters found;
    bsdf.deltas(local, found);
    const float diffuse = (allowed & NON_DELTA_LOBES) ? maxComponent(bsdf.albedo(local)) : 0;
    float total = diffuse;
    for (const DeltaScatter& d : found) total += maxComponent(d.weight);
    if (!(total > 0)) return {};
    float u = sampler.next1D() * total;
    if (u < diffuse) {
      std::optional<Scatter> s = scatterNonDelta(wi, transport, sampler);
      if (s) {
        s->weight *= total / diffuse;
        s->pdf *= diffuse / total;
      }
      return s;
    }
    u -= diffuse;
    const DeltaScatter* chosen = nullptr;
    for (const DeltaScatter& d : found) {
      const float share = maxComponent(d.weight);
      if (share <= 0) continue;
      chosen = &d;
      if (u < share) break;
      u -= share;
    }
    std::optional<Scatter> s = toWorld(wi, local, *chosen, transport);
    if (s) {
      s->pdf = maxComponent(chosen->weight) / total;
      s->weight /= s->pdf;
    }
    return s;
  }

  /** Samples a step by the non-delta lobes only. */
  std::optional<Scatter> scatterNonDelta(const Vec3f& wi, Transport transport, Sampler& sampler) const {
    const Vec2f u = sampler.next2D();
    if (guide && transport == Transport::RADIANCE) return scatterGuided(wi, u, sampler);
    if (lobeSet & LAMBERTIAN) return scatterLambertian(wi, transport, u);
    const Vec3f local = frame.toLocal(wi);
    const std::optional<Vec3f> wo = bsdf.sample(local, u, sampler.next1D());
    if (!wo) return {};
    Scatter s;
    s.direction = frame.toWorld(*wo);
    s.pdf = bsdf.pdf(local, *wo);
    if (!(s.pdf > 0) || leaks(wi, s.direction)) return {};
    s.lobe = local.z * wo->z > 0 ? REFLECTION : TRANSMISSION;
    // Radiance flows in the opposite direction, which at refraction includes the factor 1/η².
    const Rgb f = transport == Transport::FLUX ? fluxValue(local, *wo) : bsdf.value(*wo, local);
    s.weight = f * (std::abs(wo->z) / s.pdf);
    if (s.lobe == TRANSMISSION) s.eta = local.z > 0 ? bsdf.eta() : 1 / bsdf.eta();
    if (transport == Transport::FLUX) s.weight *= shadingNormalFactor(wi, local, s.direction, *wo);
    return s;
  }

  /** Enumerates all delta steps, and returns their number. Each has pdf 1: its weight is not divided by a
   * selection probability. */
  int deltaScatters(const Vec3f& wi, Transport transport,
                    std::array<Scatter, DeltaScatters::MAX_COUNT>& out) const {
    const Vec3f local = frame.toLocal(wi);
    DeltaScatters found;
    bsdf.deltas(local, found);
    int n = 0;
    for (const DeltaScatter& d : found)
      if (const std::optional<Scatter> s = toWorld(wi, local, d, transport))
        out[static_cast<size_t>(n++)] = *s;
    return n;
  }

  // Steps by lobes of one kind. Empty: absorbed, or no such lobe. Delta steps have pdf 1.

  /** Step of a photon by the non-delta lobes: flux towards a sampled direction. */
  std::optional<Scatter> diffuseForwardScatter(const Vec3f& wi, Sampler& sampler) const {
    return scatterNonDelta(wi, Transport::FLUX, sampler);
  }
  /** Mirror step of a camera path; BSDFs have one mirror lobe, the sum of all their layers or parts. */
  std::optional<Scatter> specularReflectionBackwardScatter(const Vec3f& wi) const {
    return firstDelta(wi, MIRROR);
  }
  /** Refraction step of a camera path, with radiance scaling; the first one where there are several. */
  std::optional<Scatter> specularRefractionBackwardScatter(const Vec3f& wi) const {
    return firstDelta(wi, REFRACTION);
  }
  /** Refraction step of a camera path; of several, one is sampled, and its weight is divided by the
   * probability of the choice. */
  std::optional<Scatter> specularRefractionBackwardScatter(const Vec3f& wi, Sampler& sampler) const;

  /** Shading normal. */
  const Vec3f& normal() const { return frame.z; }

 private:
  /** BSDF for flux from wi to wo. A curve that faces its ray is turned to the photon, while the camera sees a
   * different side of it. Averaged over the width, both see mirrored configurations if their inclinations to
   * the curve are exchanged and their azimuths are kept. */
  Rgb fluxValue(const Vec3f& wi, const Vec3f& wo) const {
    if (!(lobeSet & FIBRE) || curve != SurfacePoint::Curve::FACES_RAY) return bsdf.value(wi, wo);
    const float across = std::sqrt((1 - square(wi.x)) / (1 - square(wo.x)));
    if (!(across > 0 && across < INFINITE)) return BLACK;
    return bsdf.value({wi.x, wo.y * across, wo.z * across}, {wo.x, wi.y / across, wi.z / across});
  }

  /** Samples a step by the BSDF or by the guide; its density is the mixture of both (one-sample balance
   * heuristic, Veach 1997, section 9.2.4). */
  std::optional<Scatter> scatterGuided(const Vec3f& wi, const Vec2f& u, Sampler& sampler) const {
    const float a = guide->bsdfProbability(), choice = sampler.next1D();
    const Vec3f local = frame.toLocal(wi);
    Scatter s;
    float byGuide = 0;
    if (choice < a) {
      const std::optional<Vec3f> wo = bsdf.sample(local, u, choice / a);
      if (!wo) return {};
      s.direction = frame.toWorld(*wo);
      byGuide = guide->pdf(s.direction);
    } else {
      s.direction = guide->sample(u, byGuide);
    }
    s.pdf = a * pdfBsdf(wi, s.direction) + (1 - a) * byGuide;
    const Rgb f = evaluate(wi, s.direction);
    if (!(s.pdf > 0) || isBlack(f)) return {};
    s.weight = f / s.pdf;
    s.lobe = REFLECTION;
    const float albedo = maxComponent(bsdf.albedo(local)); // 0: unknown
    if (albedo > 0) s.rouletteScale = albedo / maxComponent(s.weight);
    return s;
  }

  /** Samples a Lambertian lobe by cosine, where the weight is the albedo. Most surfaces of most scenes are of
   * this kind, so that no virtual function is called. */
  std::optional<Scatter> scatterLambertian(const Vec3f& wi, Transport transport, const Vec2f& u) const {
    Vec3f local = cosineHemisphere(u);
    const float cosI = glm::dot(wi, frame.z);
    if (cosI < 0) local.z = -local.z;
    Scatter s;
    s.direction = frame.toWorld(local);
    s.pdf = std::abs(local.z) * INV_PI;
    if (!(s.pdf > 0) || cosI == 0 || leaks(wi, s.direction)) return {};
    s.weight = constant * PI;
    s.lobe = REFLECTION;
    if (transport == Transport::FLUX)
      s.weight *= shadingNormalFactor(wi, frame.toLocal(wi), s.direction, local);
    return s;
  }

  /** True where geometric and shading normal disagree on whether both directions are on the same side. */
  bool leaks(const Vec3f& wi, const Vec3f& wo) const {
    const bool sameGeometric = glm::dot(wi, geometricNormal) * glm::dot(wo, geometricNormal) > 0;
    const bool sameShading = glm::dot(wi, frame.z) * glm::dot(wo, frame.z) > 0;
    return sameGeometric != sameShading;
  }

  float nonDeltaProbability(const Vec3f& local) const {
    DeltaScatters found;
    bsdf.deltas(local, found);
    const float diffuse = maxComponent(bsdf.albedo(local));
    float total = diffuse;
    for (const DeltaScatter& d : found) total += maxComponent(d.weight);
    return total > 0 ? diffuse / total : 0;
  }

  float shadingNormalFactor(const Vec3f& wi, const Vec3f& wiLocal, const Vec3f& wo,
                            const Vec3f& woLocal) const {
    if (frame.z == geometricNormal)
      return 1; // exactly 1: at grazing angles the quotient would be rounding error alone
    const float denominator = absDot(wi, geometricNormal) * std::abs(woLocal.z);
    if (denominator == 0) return 0; // a photon parallel to the surface carries no flux into it
    return std::abs(wiLocal.z) * absDot(wo, geometricNormal) / denominator;
  }

  std::optional<Scatter> toWorld(const Vec3f& wi, const Vec3f& local, const DeltaScatter& d,
                                 Transport transport) const {
    Scatter s;
    s.direction = glm::normalize(frame.toWorld(d.wo));
    if (leaks(wi, s.direction)) return {};
    s.weight = d.weight;
    s.pdf = 1;
    s.lobe = d.lobe;
    s.eta = d.eta;
    if (transport == Transport::RADIANCE)
      s.weight /= square(d.eta);
    else
      s.weight *= shadingNormalFactor(wi, local, s.direction, d.wo);
    return s;
  }

  std::optional<Scatter> firstDelta(const Vec3f& wi, Lobe lobe) const {
    std::array<Scatter, DeltaScatters::MAX_COUNT> all;
    const int n = deltaScatters(wi, Transport::RADIANCE, all);
    for (int i = 0; i < n; ++i)
      if (all[static_cast<size_t>(i)].lobe == lobe) return all[static_cast<size_t>(i)];
    return {};
  }

  const Bsdf& bsdf;
  Frame frame;
  Vec3f geometricNormal;
  LobeSet lobeSet;
  SurfacePoint::Curve curve;
  Rgb constant{0};                       ///< value of a Lambertian BSDF
  const DirectionGuide* guide = nullptr; ///< for radiance walks; null: BSDF sampling only
};

inline std::optional<Scatter> ScatteringPoint::specularRefractionBackwardScatter(const Vec3f& wi,
                                                                                 Sampler& sampler) const {
  std::array<Scatter, DeltaScatters::MAX_COUNT> all;
  const int count = deltaScatters(wi, Transport::RADIANCE, all);
  std::optional<Scatter> chosen;
  float total = 0, chance = 0;
  for (int i = 0; i < count; ++i) {
    const Scatter& s = all[static_cast<size_t>(i)];
    const float weight = s.lobe == REFRACTION ? maxComponent(s.weight) * square(s.eta) : 0;
    if (!(weight > 0)) continue;
    total += weight;
    if (chosen && sampler.next1D() * total >= weight) continue;
    chosen = s;
    chance = weight;
  }
  if (chosen) chosen->weight *= total / chance;
  return chosen;
}

} // namespace recurse
