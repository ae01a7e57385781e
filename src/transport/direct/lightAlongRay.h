/** @file
 * Sampling of the distances at which a homogeneous medium scatters light of lamps into a ray: by
 * transmittance, by proximity to a lamp, and by the incident light.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "transport/direct/directLight.h"

namespace recurse {

/** Distances on [0, end] with density proportional to the transmittance of a uniformly chosen channel. `end`
 * may be infinite. The extinction must not be black. */
class TransmittanceDistance {
 public:
  TransmittanceDistance(const Rgb& extinction, float end) : end(end) {
    for (int c = 0; c < 3; ++c)
      if (extinction[c] > 0) rates[count++] = extinction[c];
  }

  float sample(float channel, float u) const {
    const float rate = rates[std::min(count - 1, size_t(channel * static_cast<float>(count)))];
    return std::min(end, -std::log1p(u * std::expm1(-rate * end)) / rate);
  }
  /** Density of distance t [1/length]. */
  float pdf(float t) const {
    float sum = 0;
    for (size_t i = 0; i < count; ++i)
      sum -= rates[i] * std::exp(-rates[i] * t) / (std::expm1(-rates[i] * end) * static_cast<float>(count));
    return sum;
  }

 private:
  float end;
  std::array<float, 3> rates;
  size_t count = 0;
};

/** Distances on [0, end] of a ray of unit direction, with density proportional to 1/r² from a point (Kulla
 * and Fajardo 2012, "Importance Sampling Techniques for Path Tracing in Participating Media"). */
class EquiangularDistance {
 public:
  EquiangularDistance(const Ray& ray, float end, const Vec3f& point) {
    const Vec3f to = point - ray.origin;
    nearest = glm::dot(to, ray.direction);
    away = glm::length(to - nearest * ray.direction);
    begin = std::atan2(-nearest, away);
    angle = std::atan2(end - nearest, away) - begin;
  }

  /** False if the ray passes through the point. */
  bool usable() const { return away > 1e-6f * std::abs(nearest) && angle > 0; }
  float sample(float u) const { return std::max(nearest + away * std::tan(begin + u * angle), 0.0f); }
  /** Density of distance t [1/length]. */
  float pdf(float t) const { return away / (angle * (square(away) + square(t - nearest))); }

 private:
  float nearest; ///< distance along the ray to the closest approach to the point
  float away;    ///< distance of the point from the ray
  float begin, angle;
};

/** Number of shadow rays towards lights that start along a ray. */
struct RaysToLights {
  int area = 1;   ///< towards area lights, whose shadows in a medium have soft edges
  int others = 1; ///< towards all other lights; at least `area`, since their shadows are sharp

  int to(const Light& light) const { return light.kind() == LightKind::AREA ? area : others; }
};

/** Light that a medium scatters into a ray, without visibility. */
struct LightAlongRay {
  float t = 0;             ///< distance along the ray
  LiSample light;          ///< light sample at that distance
  uint32_t index = 0;      ///< number of the light
  float reciprocalPdf = 0; ///< RIS estimate of 1/pdf of distance, lamp and direction, over the number of rays
                           ///< to the lamp [length·sr]
};

/**
 * Draws sample `which`, in [0, rays.others), for a ray of unit direction through a homogeneous medium that
 * ends at `end`. Samples towards `others` are stratified by distance. Resampled importance sampling (Talbot,
 * Cline and Egbert 2005, "Importance Resampling for Global Illumination") selects it from candidates, half of
 * them by transmittance and half equiangular about a lamp. Returns nullopt if no candidate is lit, or if
 * `which` is not below the number of rays to the chosen lamp.
 */
std::optional<LightAlongRay> sampleLightAlong(const Scene& scene, const LightSampler& lightSampler,
                                              const Medium& medium, const Ray& ray, float end,
                                              const RaysToLights& rays, int which, Sampler& sampler);

} // namespace recurse
