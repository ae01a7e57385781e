/** @file
 * Flights through media: where light scatters next, and what of it arrives. One colour channel, the hero,
 * draws all events of a path, weighted by the one-sample balance heuristic over channels and techniques
 * (Miller, Georgiev and Jarosz 2019, "A null-scattering path integral formulation of light transport");
 * doc-files/notes/media.md says more.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "recurse/core/sampling/sampler.h"
#include "recurse/model/medium/medium.h"

namespace recurse {

/** What a path carries through media. */
struct SpectralPath {
  Rgb throughput{1}; ///< over the mean density of the channels
  Rgb pathPdf{1};    ///< densities by channel with which the path came here, relative to their mean
  Rgb lightPdf{1};   ///< the same of a shadow ray from the last vertex to here, per density of its direction

  /** Makes the mean of `pathPdf` 1, which changes no quotient. */
  void normalize() {
    const float mean = (pathPdf.r + pathPdf.g + pathPdf.b) * (1.0f / 3);
    if (!(mean > 0)) return;
    throughput /= mean;
    lightPdf /= mean;
    pathPdf /= mean;
  }
};

/** What arrives along a shadow ray: of radiance, and densities by channel of a path that goes on (pathPdf)
 * and of the shadow ray (light), relative to what was before. */
struct SpectralTransmittance {
  Rgb value{1}, pathPdf{1}, lightPdf{1};
};

namespace flight {

/** exp(-extinction · distance), also where one is 0 and the other infinite. */
inline Rgb transmittance(const Rgb& extinction, float distance) {
  Rgb t;
  for (int c = 0; c < 3; ++c) t[c] = extinction[c] == 0 ? 1 : std::exp(-extinction[c] * distance);
  return t;
}

inline float sampleDistance(float extinction, Sampler& sampler) {
  return extinction > 0 ? -std::log1p(-sampler.next1D()) / extinction : INFINITE;
}

/** Roulette of a flight that has lost nearly all: true to go on, with a larger `value`. `density`: the mean
 * of the densities that the value is to be divided by. */
inline bool survives(Rgb& value, float density, Sampler& sampler) {
  constexpr float LOW = 0.05f, LOST = 0.75f;
  if (maxComponent(value) >= LOW * density) return true;
  if (sampler.next1D() < LOST) return false;
  value /= 1 - LOST;
  return true;
}

} // namespace flight

/** What becomes of light that a medium absorbs. */
enum class Absorption {
  SAMPLED, ///< flights end where light is absorbed or scatters; only there it is taken off the throughput
  EXPECTED ///< the same, but in matter that does not scatter at all flights lose what it absorbs, and go on
};

/** Coefficients by which flights end [1/length]. */
inline Rgb stoppingCoefficient(const MediumPoint& medium, Absorption absorption) {
  return absorption == Absorption::EXPECTED && isBlack(medium.scattering) ? BLACK : medium.extinction();
}

/**
 * Density of where a flight over `end` in a homogeneous medium scatters, by channel. Where
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

  /** Where light scatters by a channel; empty: it arrives. */
  std::optional<float> sample(int channel, Sampler& sampler) const {
    if (!(stop[channel] > 0)) return {};
    const float u = sampler.next1D() / stop[channel];
    if (!(u < 1)) return {};
    const float sigma = extinction[channel];
    return std::min(end, -std::log1p(u * std::expm1(-sigma * end)) / sigma);
  }
  /** Probability of arriving. */
  const Rgb& arrivalProbability() const { return arrival; }
  /** [1/length] */
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

/** What a homogeneous medium emits along a flight, as radiance. */
inline Rgb emittedAlong(const MediumPoint& medium, float end) {
  const Rgb extinction = medium.extinction();
  Rgb emitted(0);
  for (int c = 0; c < 3; ++c)
    if (medium.emission[c] > 0)
      emitted[c] = medium.emission[c] / extinction[c] * -std::expm1(-extinction[c] * end);
  return emitted;
}

/** A tentative collision in a heterogeneous medium: light scatters there, or goes on through what is missing
 * to the bound. */
struct NullCollision {
  Rgb coefficient; ///< of going on [1/length]
  Rgb stop, pass;  ///< probabilities by channel

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

/** Whether a flight found a place to scatter at. */
struct Collision {
  bool scatters = false;
  float t = 0;
};

/** sampleCollision() in a homogeneous medium. */
template <class Emission>
Collision sampleHomogeneousCollision(const MediumPoint& medium, float end, int hero, Absorption absorption,
                                     Sampler& sampler, SpectralPath& path, Emission&& emission) {
  if (!isBlack(medium.emission))
    emission(path.throughput * emittedAlong(medium, end) *
             (3 / (path.pathPdf.r + path.pathPdf.g + path.pathPdf.b)));
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
 * Flies along a ray of unit direction as far as the surface at `end`, or to where the medium scatters by the
 * hero channel. `emission(radiance)` is called with what the medium emits on the way, times the throughput,
 * which is black afterwards where nothing is left.
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
        emission(path.throughput * point.emission * (3 / (majorant * (density.r + density.g + density.b))));
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

/** The hero of what carries no densities: ratio tracking by the densest channel's bound, where no weight is
 * above 1. */
constexpr int NO_HERO = -1;

/** Carries a shadow ray through as far as `end`: by closed form where there is one, by ratio tracking else.
 * The path that goes on expects absorption. Without a hero only `value` has a meaning. */
inline void trackTransmittance(const Medium& medium, const Ray& ray, float end, int hero, Sampler& sampler,
                               SpectralTransmittance& s) {
  if (medium.isHomogeneous()) {
    const MediumPoint point = medium.at(ray.origin);
    s.value *= flight::transmittance(point.extinction(), end);
    s.pathPdf *= FlightDensity(point, end, Absorption::EXPECTED).arrivalProbability();
    return;
  }
  MajorantSegments segments = medium.segments(ray, end);
  for (MajorantSegment part; segments.next(part);) {
    if (hero == NO_HERO) part.majorant = Rgb(maxComponent(part.majorant));
    const float majorant = part.majorant[std::max(hero, 0)];
    for (float t = part.begin;;) {
      const float step = flight::sampleDistance(majorant, sampler);
      const bool arrives = !(t + step < part.end);
      const Rgb relative = flight::transmittance(part.majorant - majorant, arrives ? part.end - t : step);
      s.value *= relative;
      s.pathPdf *= relative;
      s.lightPdf *= relative;
      if (arrives) break;
      t += step;
      const NullCollision null(medium.at(ray.at(t)), part.majorant, Absorption::EXPECTED);
      s.value *= null.coefficient / majorant;
      s.pathPdf *= part.majorant * null.pass / majorant;
      s.lightPdf *= part.majorant / majorant;
      const float mean =
          (s.pathPdf.r + s.pathPdf.g + s.pathPdf.b + s.lightPdf.r + s.lightPdf.g + s.lightPdf.b) / 3;
      if (!flight::survives(s.value, mean, sampler)) s.value = BLACK;
      if (isBlack(s.value)) return;
    }
  }
}

/** Transmittance from the origin of a ray of unit direction to every place on it before `end`, and what the
 * medium emits up to there: closed forms, or in heterogeneous media one run of ratio tracking, whose steps
 * have the right mean at each place. */
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
  /** Radiance of the medium on the whole way. */
  const Rgb& emitted() const { return emission; }

 private:
  struct Step {
    float t;
    Rgb value; ///< from t on
  };

  void track(const Medium& medium, const Ray& ray, float end, Sampler& sampler) {
    constexpr float LOW = 0.01f; // is followed by roulette
    Rgb value(1);
    MajorantSegments segments = medium.segments(ray, end);
    for (MajorantSegment part; segments.next(part);) {
      const float majorant = maxComponent(part.majorant);
      for (float t = part.begin;;) {
        t += flight::sampleDistance(majorant, sampler);
        if (!(t < part.end)) break;
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
