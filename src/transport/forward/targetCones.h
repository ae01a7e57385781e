/** @file
 * Cones to the DXTRAN spheres from the point where a photon scatters.
 */
#pragma once

#include <algorithm>
#include <vector>

#include "transport/forward/shootSettings.h"

namespace recurse {

/** Distance in radii below which a sphere is too wide for a cone. */
constexpr float NEAR_TARGET = 1.5f;

/** Cones to the DXTRAN spheres from one point. */
class TargetCones {
 public:
  struct Target {
    Cone cone;
    float part;
  };

  /** Computes the cones from a point. Returns false, with an incomplete list, if it is not outside of all. */
  bool find(const std::vector<DxtranSphere>& targets, const Vec3f& from) {
    cones.clear();
    for (const DxtranSphere& t : targets) {
      if (!(lengthSquared(t.center - from) > square(NEAR_TARGET * t.radius))) return false;
      cones.push_back({Cone::toSphere(from, t.center, t.radius), t.part});
    }
    return true;
  }
  /** Number of cones that contain a direction. */
  std::ptrdiff_t around(const Vec3f& direction) const {
    return std::count_if(cones.begin(), cones.end(),
                         [&](const Target& t) { return t.cone.contains(direction); });
  }
  auto begin() const { return cones.begin(); }
  auto end() const { return cones.end(); }

 private:
  std::vector<Target> cones;
};

} // namespace recurse
