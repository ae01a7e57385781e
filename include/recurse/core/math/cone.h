/** @file
 * The directions from a point in which a sphere is seen.
 */
#pragma once

#include <algorithm>

#include "recurse/core/sampling/sampling.h"

namespace recurse {

struct Cone {
  Vec3f axis{0, 0, 1}; ///< unit
  float opening = 2;   ///< 1 - cosine of half the angle, without cancellation; 2: all directions

  /** All directions from inside of the sphere. */
  static Cone toSphere(const Vec3f& from, const Vec3f& center, float radius) {
    const Vec3f way = center - from;
    const float distance2 = lengthSquared(way), sine2 = square(radius) / distance2;
    if (!(sine2 < 1)) return {};
    return {way / std::sqrt(distance2), sine2 / (1 + std::sqrt(1 - sine2))};
  }
  bool contains(const Vec3f& direction) const { return lengthSquared(direction - axis) <= 2 * opening; }
  /** Of uniform directions within [1/sr]. */
  float pdf() const { return 1 / (2 * PI * opening); }
  Vec3f sample(const Vec2f& u) const { return Frame(axis).toWorld(uniformCone(u, opening)); }
};

} // namespace recurse
