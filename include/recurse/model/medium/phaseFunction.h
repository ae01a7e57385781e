/** @file
 * Phase functions: how a medium scatters. A plug-in is three functions of the cosine between the directions
 * of flight before and after; all are symmetric about the direction before.
 */
#pragma once

#include "recurse/core/sampling/sampling.h"

namespace recurse {

class PhaseFunction {
 public:
  virtual ~PhaseFunction() = default;
  /** Density per solid angle [1/sr] of going on at an angle of this cosine in [-1, 1], 1 being straight on.
   * Its integral over the sphere is 1. */
  virtual float value(float cosine) const = 0;
  /** A cosine with that density, from u in [0, 1). */
  virtual float sampleCosine(float u) const = 0;
  /** The mean of the cosine, g. */
  virtual float meanCosine() const = 0;

  /** A direction with density value(), for a flight in unit `direction`. */
  Vec3f sample(const Vec3f& direction, const Vec2f& u) const {
    const float z = std::clamp(sampleCosine(u.x), -1.0f, 1.0f);
    const float r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * PI * u.y;
    return Frame(direction).toWorld({r * std::cos(phi), r * std::sin(phi), z});
  }
};

} // namespace recurse
