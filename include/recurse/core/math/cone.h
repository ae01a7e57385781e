/** @file
 * Cone of directions that a sphere subtends at a point.
 */
#pragma once

#include <algorithm>

#include "recurse/core/sampling/sampling.h"

namespace recurse {

struct Cone {
  Vec3f axis{0, 0, 1}; ///< unit
  float opening = 2;   ///< 1 − cosine of the half-angle, without cancellation; 2: all directions

  /** Cone from a point to a sphere; all directions where the point is inside of it. */
  static Cone toSphere(const Vec3f& from, const Vec3f& center, float radius) {
    const Vec3f way = center - from;
    const float distance2 = lengthSquared(way), sine2 = square(radius) / distance2;
    if (!(sine2 < 1)) return {};
    return {way / std::sqrt(distance2), sine2 / (1 + std::sqrt(1 - sine2))};
  }
  /** True for a unit `direction` within the cone. */
  bool contains(const Vec3f& direction) const { return lengthSquared(direction - axis) <= 2 * opening; }
  /** Density of uniform directions within the cone [1/sr]. */
  float pdf() const { return 1 / (2 * PI * opening); }
  /** Samples a unit direction with density pdf(), by u in [0, 1)². */
  Vec3f sample(const Vec2f& u) const { return Frame(axis).toWorld(uniformCone(u, opening)); }
};

} // namespace recurse
