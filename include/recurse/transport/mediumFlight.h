/** @file
 * Flights through media: where light scatters next, and what of it arrives. One colour channel, the hero,
 * draws all events of a path, weighted by the one-sample balance heuristic over channels and techniques
 * (Miller, Georgiev and Jarosz 2019, "A null-scattering path integral formulation of light transport");
 * doc-files/notes/media.md says more.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "recurse/core/sampler.h"
#include "recurse/model/medium.h"

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

} // namespace flight

/** Whether a flight found a place to scatter at. */
struct Collision {
  bool scatters = false;
  float t = 0;
};

/**
 * Flies along a ray of unit direction as far as the surface at `end`, or to where the medium scatters by the
 * hero channel. `emission(radiance)` is called with what the medium emits on the way, times the throughput.
 * What is absorbed is taken off the throughput, and only ends the path where nothing is left.
 */
template <class Emission>
Collision sampleCollision(const Medium& medium, const Ray& ray, float end, int hero, Sampler& sampler,
                          SpectralPath& path, Emission&& emission) {
  const bool exact = medium.isHomogeneous();
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
      if (arrives) {
        path.lightPdf *= exact ? Rgb(1 / flight::transmittance(Rgb(majorant), distance).r) : relative;
        path.normalize();
        break;
      }
      t += step;
      const MediumPoint point = medium.at(ray.at(t));
      if (!isBlack(point.emission)) {
        const Rgb density = path.pathPdf * s.majorant / majorant;
        emission(path.throughput * point.emission * (3 / (majorant * (density.r + density.g + density.b))));
      }
      const Rgb extinction = point.extinction();
      if (exact || sampler.next1D() * majorant < extinction[hero]) {
        path.throughput *= point.scattering / extinction[hero];
        path.pathPdf *= extinction / extinction[hero];
        path.normalize();
        return {true, t};
      }
      const Rgb null = max(s.majorant - extinction, 0);
      if (!(null[hero] > 0)) continue; // rounding
      path.throughput *= null / null[hero];
      path.pathPdf *= null / null[hero];
      path.lightPdf *= relative * s.majorant / null[hero];
      path.normalize();
    }
  }
  return {};
}

/** The hero of what carries no densities: ratio tracking by the densest channel's bound, where no weight is
 * above 1. */
constexpr int NO_HERO = -1;

/** Carries a shadow ray through as far as `end`: by closed form where there is one, by ratio tracking else.
 * Without a hero only `value` has a meaning. */
inline void trackTransmittance(const Medium& medium, const Ray& ray, float end, int hero, Sampler& sampler,
                               SpectralTransmittance& s) {
  constexpr float LOW = 0.05f, LOST = 0.75f; // of light that is hardly worth following
  MajorantSegments segments = medium.segments(ray, end);
  for (MajorantSegment part; segments.next(part);) {
    if (medium.isHomogeneous()) {
      const Rgb t = flight::transmittance(part.majorant, part.end - part.begin);
      s.value *= t;
      s.pathPdf *= t;
      continue;
    }
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
      const Rgb null = max(part.majorant - medium.at(ray.at(t)).extinction(), 0) / majorant;
      s.value *= null;
      s.pathPdf *= null;
      s.lightPdf *= part.majorant / majorant;
      if (isBlack(s.value)) return;
      const float mean =
          (s.pathPdf.r + s.pathPdf.g + s.pathPdf.b + s.lightPdf.r + s.lightPdf.g + s.lightPdf.b) / 3;
      if (maxComponent(s.value) < LOW * mean) {
        if (sampler.next1D() < LOST) {
          s.value = BLACK;
          return;
        }
        s.value /= 1 - LOST;
      }
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
    for (int c = 0; c < 3; ++c)
      if (point.emission[c] > 0)
        emission[c] = point.emission[c] / extinction[c] * -std::expm1(-extinction[c] * end);
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
