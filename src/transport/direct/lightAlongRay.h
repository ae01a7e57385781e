/** @file
 * Where along a ray through a homogeneous medium the light of lamps is looked for: by what the medium lets
 * through, by how near the ray comes to a lamp, and by what lamps send there.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "transport/direct/directLight.h"

namespace recurse {

/** Distances on [0, end] in proportion to the transmittance of a channel that is chosen evenly. `end` may be
 * infinite. */
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
  /** [1/length] */
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

/** Distances on [0, end] of a ray of unit direction, in proportion to 1/r² about a point (Kulla and Fajardo
 * 2012, "Importance Sampling Techniques for Path Tracing in Participating Media"). */
class EquiangularDistance {
 public:
  EquiangularDistance(const Ray& ray, float end, const Vec3f& point) {
    const Vec3f to = point - ray.origin;
    nearest = glm::dot(to, ray.direction);
    away = glm::length(to - nearest * ray.direction);
    begin = std::atan2(-nearest, away);
    angle = std::atan2(end - nearest, away) - begin;
  }

  /** False where the ray goes through the point. */
  bool usable() const { return away > 1e-6f * std::abs(nearest) && angle > 0; }
  float sample(float u) const { return std::max(nearest + away * std::tan(begin + u * angle), 0.0f); }
  /** [1/length] */
  float pdf(float t) const { return away / (angle * (square(away) + square(t - nearest))); }

 private:
  float nearest; ///< distance along the ray to where it is nearest to the point
  float away;    ///< of the point from there
  float begin, angle;
};

/** How many shadow rays towards lights start along a ray. */
struct RaysToLights {
  int area = 1;   ///< towards those with a surface, whose shadows in a medium have soft edges
  int others = 1; ///< at least as many: shafts of light between sharp shadows

  int to(const Light& light) const { return light.kind() == LightKind::AREA ? area : others; }
};

/** Light that a medium scatters into a ray, unless something is in its way. */
struct LightAlongRay {
  float t = 0;             ///< distance along the ray
  LiSample light;          ///< seen from there
  float reciprocalPdf = 0; ///< of distance, lamp and direction in all samples, by its mean [length·sr]
};

/**
 * Sample `which` of `rays.others` for a ray of unit direction through a homogeneous medium that ends at
 * `end`; those towards `others` are stratified by distance. It is one of some candidates, half of them by
 * transmittance and half by nearness to a lamp, by resampled importance sampling (Talbot, Cline and Egbert
 * 2005, "Importance Resampling for Global Illumination"). None where no lamp lights either, or where the lamp
 * that was chosen has its rays.
 */
std::optional<LightAlongRay> sampleLightAlong(const Scene& scene, const LightSampler& lightSampler,
                                              const Medium& medium, const Ray& ray, float end,
                                              const RaysToLights& rays, int which, Sampler& sampler);

} // namespace recurse
