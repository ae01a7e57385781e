/** @file
 * The spheres that photons are sent to, as they are seen from where a photon scatters.
 */
#pragma once

#include <algorithm>
#include <vector>

#include "transport/forward/shootSettings.h"

namespace recurse {

/** Nearer than so many radii a target is too wide for a cone. */
constexpr float NEAR_TARGET = 1.5f;

/** Cones to the DXTRAN spheres from one place. */
class TargetCones {
 public:
  struct Target {
    Cone cone;
    float part;
  };

  /** True when the place is outside of all; only then they are complete. */
  bool find(const std::vector<DxtranSphere>& targets, const Vec3f& from) {
    cones.clear();
    for (const DxtranSphere& t : targets) {
      if (!(lengthSquared(t.center - from) > square(NEAR_TARGET * t.radius))) return false;
      cones.push_back({Cone::toSphere(from, t.center, t.radius), t.part});
    }
    return true;
  }
  /** How many a direction lies in. */
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
