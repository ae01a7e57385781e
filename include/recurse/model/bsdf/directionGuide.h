/** @file
 * A learned density over directions that the sampling of BSDFs is mixed with.
 */
#pragma once

#include "recurse/core/math/vector.h"

namespace recurse {

/** A density over directions at a place, by which light arrives there, whatever the BSDF. */
class DirectionGuide {
 public:
  virtual ~DirectionGuide() = default;

  /** Density of a unit direction [1/sr]; may be zero, since the BSDF is sampled too. */
  virtual float pdf(const Vec3f& direction) const = 0;
  /** Unit direction with that density, which goes to `density`. */
  virtual Vec3f sample(Vec2f u, float& density) const = 0;
  /** Probability of sampling the BSDF, in (0, 1). */
  virtual float bsdfProbability() const = 0;
};

} // namespace recurse
