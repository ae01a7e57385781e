/** @file
 * Phase functions: the distribution of scattering in a medium. A plug-in is three functions of the cosine
 * between the propagation directions before and after; all are symmetric about the former.
 */
#pragma once

#include "recurse/core/sampling/sampling.h"

namespace recurse {

class PhaseFunction {
 public:
  virtual ~PhaseFunction() = default;
  /** Density of scattering at an angle of this cosine in [-1, 1], where 1 is straight on [1/sr]. The integral
   * over the sphere is 1. */
  virtual float value(float cosine) const = 0;
  /** Samples a cosine in proportion to value(), by u in [0, 1). */
  virtual float sampleCosine(float u) const = 0;
  /** Mean cosine g. */
  virtual float meanCosine() const = 0;

  /** Samples a direction with density value(), for a propagation along unit `direction`. */
  Vec3f sample(const Vec3f& direction, const Vec2f& u) const {
    const float z = std::clamp(sampleCosine(u.x), -1.0f, 1.0f);
    const float r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * PI * u.y;
    return Frame(direction).toWorld({r * std::cos(phi), r * std::sin(phi), z});
  }
};

} // namespace recurse
