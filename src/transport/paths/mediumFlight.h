/** @file
 * Free flight in media: sampling of the next collision, and transmittance. One colour channel, the hero,
 * draws all events of a path, weighted by the one-sample balance heuristic over channels and techniques
 * (Miller, Georgiev and Jarosz 2019, "A null-scattering path integral formulation of light transport").
 * Derivations are in doc-files/notes/media.md.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "recurse/core/sampling/sampler.h"
#include "recurse/model/medium/medium.h"

namespace recurse {

/** Colour channel that draws distances in media, by a number u in [0, 1). */
inline int drawHero(float u) { return std::min(2, static_cast<int>(3 * u)); }

/** Spectral state of a path in media, by colour channel. */
struct SpectralPath {
  Rgb throughput{1}; ///< path throughput over the mean of pathPdf
  Rgb pathPdf{1};    ///< densities of the path by channel, relative to their mean
  Rgb lightPdf{1};   ///< densities of a shadow ray from the last vertex, over its direction's density

  /** Scales all three so that the mean of `pathPdf` is 1. Their ratios do not change. */
  void normalize() {
    const float mean = channelSum(pathPdf) * (1.0f / 3);
    if (!(mean > 0)) return;
    throughput /= mean;
    lightPdf /= mean;
    pathPdf /= mean;
  }
};

/** Transmittance of a shadow ray, and per channel the media's factors on the densities of continuation
 * (pathPdf) and light sampling (lightPdf). */
struct SpectralTransmittance {
  Rgb value{1}, pathPdf{1}, lightPdf{1};
};

namespace flight {

/** Transmittance exp(-extinction · distance), also defined for 0 · infinity. */
inline Rgb transmittance(const Rgb& extinction, float distance) {
  Rgb t;
  for (int c = 0; c < 3; ++c) t[c] = extinction[c] == 0 ? 1 : std::exp(-extinction[c] * distance);
  return t;
}

inline float sampleDistance(float extinction, Sampler& sampler) {
  return extinction > 0 ? -std::log1p(-sampler.next1D()) / extinction : INFINITE;
}

/** Russian roulette of a nearly absorbed flight. Returns true if it survives, with an increased `value`.
 * `density`: mean of the densities that the value will be divided by. */
inline bool survives(Rgb& value, float density, Sampler& sampler) {
  constexpr float LOW = 0.05f, LOST = 0.75f;
  if (maxComponent(value) >= LOW * density) return true;
  if (sampler.next1D() < LOST) return false;
  value /= 1 - LOST;
  return true;
}

} // namespace flight

/** Treatment of absorption along a flight. */
enum class Absorption {
  SAMPLED, ///< flights end where light is absorbed or scatters; the albedo is applied there
  EXPECTED ///< like SAMPLED, but in media without scattering flights never end and the throughput decays
};

/** Coefficient of the events that end a flight [1/length]. */
inline Rgb stoppingCoefficient(const MediumPoint& medium, Absorption absorption) {
  return absorption == Absorption::EXPECTED && isBlack(medium.scattering) ? BLACK : medium.extinction();
}

/**
 * Density of the distance to the next collision on a flight of length `end` in a homogeneous medium. Where
 * absorption is expected all flights arrive, with the same throughput (doc-files/notes/media.md, equation 1).
 */
class FlightDensity {
 public:
  FlightDensity(const MediumPoint& medium, float end, Absorption absorption)
      : extinction(medium.extinction()), stopping(stoppingCoefficient(medium, absorption)),
        transmittance(flight::transmittance(extinction, end)), end(end) {
    for (int c = 0; c < 3; ++c) {
      const float stopped =
          stopping[c] > 0 ? stopping[c] / extinction[c] * -std::expm1(-extinction[c] * end) : 0;
      survival[c] = stopped + transmittance[c];
      stop[c] = stopped > 0 ? stopped / survival[c] : 0;
      arrival[c] = stopped > 0 ? transmittance[c] / survival[c] : 1;
    }
  }

  /** Samples the distance to the collision by a channel [scene units]; nullopt: the flight arrives. */
  std::optional<float> sample(int channel, Sampler& sampler) const {
    if (!(stop[channel] > 0)) return {};
    const float u = sampler.next1D() / stop[channel];
    if (!(u < 1)) return {};
    const float sigma = extinction[channel];
    return std::min(end, -std::log1p(u * std::expm1(-sigma * end)) / sigma);
  }
  /** Probability of arriving without a collision, by channel. */
  const Rgb& arrivalProbability() const { return arrival; }
  /** Density of a collision at distance t, by channel [1/length]. */
  Rgb pdf(float t) const {
    Rgb pdf(0);
    for (int c = 0; c < 3; ++c)
      if (stopping[c] > 0) pdf[c] = stopping[c] * std::exp(-extinction[c] * t) / survival[c];
    return pdf;
  }

 private:
  Rgb extinction, stopping, transmittance, survival, stop, arrival;
  float end;
};

/** Radiance that a homogeneous medium emits along a flight of length `end`. */
inline Rgb emittedAlong(const MediumPoint& medium, float end) {
  const Rgb extinction = medium.extinction();
  Rgb emitted(0);
  for (int c = 0; c < 3; ++c)
    if (medium.emission[c] > 0)
      emitted[c] = medium.emission[c] / extinction[c] * -std::expm1(-extinction[c] * end);
  return emitted;
}

/** Tentative collision in a heterogeneous medium: a real one, by which the flight ends, or a null collision,
 * whose coefficient is the difference between majorant and extinction. */
struct NullCollision {
  Rgb coefficient; ///< null-collision coefficient [1/length]
  Rgb stop, pass;  ///< probabilities of a real and of a null collision, by channel

  NullCollision(const MediumPoint& medium, const Rgb& majorant, Absorption absorption)
      : coefficient(max(majorant - medium.extinction(), 0)) {
    const Rgb stopping = stoppingCoefficient(medium, absorption);
    for (int c = 0; c < 3; ++c) {
      const float sum = stopping[c] + coefficient[c];
      stop[c] = stopping[c] > 0 ? stopping[c] / sum : 0;
      pass[c] = stopping[c] > 0 ? coefficient[c] / sum : 1;
    }
  }
};

/** Outcome of a flight: a scattering event at distance t, or none. */
struct Collision {
  bool scatters = false;
  float t = 0;
};

/** Version of sampleCollision() for homogeneous media. */
template <class Emission>
Collision sampleHomogeneousCollision(const MediumPoint& medium, float end, int hero, Absorption absorption,
                                     Sampler& sampler, SpectralPath& path, Emission&& emission) {
  if (!isBlack(medium.emission))
    emission(path.throughput * emittedAlong(medium, end) * (3 / channelSum(path.pathPdf)));
  const FlightDensity density(medium, end, absorption);
  const std::optional<float> t = density.sample(hero, sampler);
  const Rgb pdf = t ? density.pdf(*t) : density.arrivalProbability();
  path.throughput *= flight::transmittance(medium.extinction(), t.value_or(end)) / pdf[hero];
  if (t) path.throughput *= medium.scattering;
  path.pathPdf *= pdf / pdf[hero];
  path.lightPdf /= pdf[hero];
  path.normalize();
  return {t.has_value(), t.value_or(end)};
}

/**
 * Samples a flight along a ray of unit direction, to a collision drawn by the hero channel or to the surface
 * at `end`. Calls `emission(radiance)` with the emission of the medium on the way times the throughput. The
 * throughput is black afterwards if nothing is left of it.
 */
template <class Emission>
Collision sampleCollision(const Medium& medium, const Ray& ray, float end, int hero, Absorption absorption,
                          Sampler& sampler, SpectralPath& path, Emission&& emission) {
  if (medium.isHomogeneous())
    return sampleHomogeneousCollision(medium.at(ray.origin), end, hero, absorption, sampler, path, emission);
  const float before = maxComponent(path.throughput);
  MajorantSegments segments = medium.segments(ray, end);
  for (MajorantSegment s; segments.next(s);) {
    const float majorant = s.majorant[hero];
    for (float t = s.begin;;) {
      const float step = flight::sampleDistance(majorant, sampler);
      const bool arrives = !(t + step < s.end);
      const float distance = arrives ? s.end - t : step;
      const Rgb relative = flight::transmittance(s.majorant - majorant, distance);
      path.throughput *= relative;
      path.pathPdf *= relative;
      path.lightPdf *= relative;
      if (arrives) {
        path.normalize();
        break;
      }
      t += step;
      const MediumPoint point = medium.at(ray.at(t));
      if (!isBlack(point.emission)) {
        const Rgb density = path.pathPdf * s.majorant / majorant;
        emission(path.throughput * point.emission * (3 / (majorant * channelSum(density))));
      }
      const NullCollision null(point, s.majorant, absorption);
      if (sampler.next1D() < null.stop[hero] || !(null.pass[hero] > 0)) {
        const float density = majorant * null.stop[hero];
        path.throughput *= point.scattering / density;
        path.pathPdf *= s.majorant * null.stop / density;
        path.normalize();
        return {true, t};
      }
      const float density = majorant * null.pass[hero];
      path.throughput *= null.coefficient / density;
      path.pathPdf *= s.majorant * null.pass / density;
      path.lightPdf *= s.majorant / density;
      path.normalize();
      if (!flight::survives(path.throughput, before, sampler)) path.throughput = BLACK;
      if (isBlack(path.throughput)) return {};
    }
  }
  return {};
}

/** Hero index of rays that carry no densities: ratio tracking with the majorant of the densest channel, which
 * bounds all weights by 1. */
constexpr int NO_HERO = -1;

/** Transmits a shadow ray up to `end`: in closed form for homogeneous media, else by ratio tracking. The
 * density `pathPdf` is for a path with expected absorption. Without a hero only `value` is valid. */
inline void trackTransmittance(const Medium& medium, const Ray& ray, float end, int hero, Sampler& sampler,
                               SpectralTransmittance& s) {
  if (medium.isHomogeneous()) {
    const MediumPoint point = medium.at(ray.origin);
    s.value *= flight::transmittance(point.extinction(), end);
    s.pathPdf *= FlightDensity(point, end, Absorption::EXPECTED).arrivalProbability();
    return;
  }
  MajorantSegments segments = medium.segments(ray, end);
  for (MajorantSegment segment; segments.next(segment);) {
    if (hero == NO_HERO) segment.majorant = Rgb(maxComponent(segment.majorant));
    const float majorant = segment.majorant[std::max(hero, 0)];
    for (float t = segment.begin;;) {
      const float step = flight::sampleDistance(majorant, sampler);
      const bool arrives = !(t + step < segment.end);
      const Rgb relative =
          flight::transmittance(segment.majorant - majorant, arrives ? segment.end - t : step);
      s.value *= relative;
      s.pathPdf *= relative;
      s.lightPdf *= relative;
      if (arrives) break;
      t += step;
      const NullCollision null(medium.at(ray.at(t)), segment.majorant, Absorption::EXPECTED);
      s.value *= null.coefficient / majorant;
      s.pathPdf *= segment.majorant * null.pass / majorant;
      s.lightPdf *= segment.majorant / majorant;
      const float mean =
          (s.pathPdf.r + s.pathPdf.g + s.pathPdf.b + s.lightPdf.r + s.lightPdf.g + s.lightPdf.b) / 3;
      if (!flight::survives(s.value, mean, sampler)) s.value = BLACK;
      if (isBlack(s.value)) return;
    }
  }
}

/** Transmittance from the origin of a ray of unit direction to every point on it before `end`, and the
 * emission of the medium up to `end`: in closed form for homogeneous media, else by one run of ratio
 * tracking, whose piecewise constant estimate is unbiased at each point. */
class RayTransmittance {
 public:
  RayTransmittance(const Medium& medium, const Ray& ray, float end, Sampler& sampler)
      : homogeneous(medium.isHomogeneous()) {
    if (!homogeneous) {
      track(medium, ray, end, sampler);
      return;
    }
    const MediumPoint point = medium.at(ray.origin);
    extinction = point.extinction();
    emission = emittedAlong(point, end);
  }

  Rgb to(float t) const {
    if (homogeneous) return flight::transmittance(extinction, t);
    const auto after = std::upper_bound(steps.begin(), steps.end(), t,
                                        [](float at, const Step& step) { return at < step.t; });
    return after == steps.begin() ? Rgb(1) : std::prev(after)->value;
  }
  /** Radiance emitted by the medium along the whole ray. */
  const Rgb& emitted() const { return emission; }

 private:
  struct Step {
    float t;
    Rgb value; ///< transmittance from t on
  };

  void track(const Medium& medium, const Ray& ray, float end, Sampler& sampler) {
    constexpr float LOW = 0.01f; // lower bound of the weight; below it, Russian roulette
    Rgb value(1);
    MajorantSegments segments = medium.segments(ray, end);
    for (MajorantSegment segment; segments.next(segment);) {
      const float majorant = maxComponent(segment.majorant);
      for (float t = segment.begin;;) {
        t += flight::sampleDistance(majorant, sampler);
        if (!(t < segment.end)) break;
        const MediumPoint point = medium.at(ray.at(t));
        emission += value * point.emission / majorant;
        value *= max(1.0f - point.extinction() / majorant, 0);
        if (const float left = maxComponent(value); left < LOW) {
          if (sampler.next1D() * LOW < left)
            value *= LOW / left;
          else
            value = Rgb(0);
        }
        steps.push_back({t, value});
        if (isBlack(value)) return;
      }
    }
  }

  bool homogeneous;
  Rgb extinction{0}, emission{0};
  std::vector<Step> steps;
};

} // namespace recurse
