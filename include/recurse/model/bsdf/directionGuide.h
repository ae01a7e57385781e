/** @file
 * Density over directions, which is mixed with BSDF sampling.
 */
#pragma once

#include "recurse/core/math/vector.h"

namespace recurse {

/** Density over directions at a point, independent of the BSDF. */
class DirectionGuide {
 public:
  virtual ~DirectionGuide() = default;

  /** Density of a unit direction [1/sr]; may be zero anywhere if the BSDF is sampled too. */
  virtual float pdf(const Vec3f& direction) const = 0;
  /** Samples a unit direction by u in [0, 1)², and sets `density` to its pdf(). */
  virtual Vec3f sample(Vec2f u, float& density) const = 0;
  /** Probability of sampling the BSDF, in [0, 1). */
  virtual float bsdfProbability() const = 0;
};

} // namespace recurse
