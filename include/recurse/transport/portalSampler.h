/** @file
 * Directions of shadow rays towards where light from all around comes in: windows, doors and holes that
 * camera paths have found. Mixed with the light's own directions, as in pbrt-v4's portal lights, so that
 * light by other ways is found too.
 */
#pragma once

#include <array>
#include <vector>

#include "recurse/model/light.h"
#include "recurse/model/scene.h"
#include "recurse/transport/integrator.h"

namespace recurse {

class PortalSampler {
 public:
  /** Finds portals, and takes that part of shadow rays for them that brings the least variance where camera
   * paths have their vertices; none where that is little less than without. Returns what that took. */
  TransportCounts learn(const Scene& scene);
  /** Part of the shadow rays; 0: no portals. */
  float part() const { return throughPortals; }
  bool active() const { return throughPortals > 0; }

  /** As those of the light; the same at any time. */
  std::optional<LiSample> sampleLi(const EnvironmentLight& light, const Vec3f& point, float pick,
                                   const Vec2f& u) const;
  float pdfLi(const EnvironmentLight& light, const Vec3f& from, const Vec3f& direction) const;

 private:
  static constexpr int LEVELS = 4; // 2^LEVELS boxes at the most: each is weighed for each shadow ray
  static constexpr size_t MAX_SIDES = 3 << LEVELS;
  /** A side of a box that is seen from a point. */
  struct Side {
    size_t box;
    int axis;
    float at;   ///< its coordinate on the axis
    float area; ///< its own
    float upToHere; ///< estimates of solid angles, of it and those before it
  };
  struct Sides {
    std::array<Side, MAX_SIDES> all;
    size_t count = 0;
    float solidAngle() const { return count > 0 ? all[count - 1].upToHere : 0; }
  };
  void findSides(const Vec3f& point, Sides& sides) const;
  /** Density of directions through the sides that are seen from the point [1/sr]. */
  float pdfThrough(const Sides& sides, const Vec3f& point, const Vec3f& direction) const;
  /** Second moments of light by shadow rays at vertices of camera paths, for each of `parts`. */
  std::vector<double> secondMoments(const Scene& scene, const std::vector<float>& parts,
                                    TransportCounts& counts);

  std::vector<Bounds3f> boxes; ///< disjoint but for their margins
  float throughPortals = 0;
};

} // namespace recurse
