/** @file
 * Directions of shadow rays towards where light from all around comes in: windows, doors and holes that
 * camera paths have found. Mixed with the light's own directions, as in pbrt-v4's portal lights, so that
 * light by other ways is found too.
 */
#pragma once

#include <array>
#include <span>
#include <vector>

#include "transport/direct/lightPortals.h"

namespace recurse {

class PortalSampler {
 public:
  /** Finds portals, and takes that part of shadow rays for them that brings the least variance where camera
   * paths have their vertices; none where that is little less than without. Where only most places have less,
   * because the sun shines in on a few, it is a small part. Returns what that took. */
  TransportCounts learn(const Scene& scene);
  /** Part of the shadow rays; 0: no portals. */
  float part() const { return throughPortals; }
  bool active() const { return throughPortals > 0; }

  /** As those of the light; the same at any time. */
  std::optional<LiSample> sampleLi(const EnvironmentLight& light, const Vec3f& point, float pick,
                                   const Vec2f& u) const;
  float pdfLi(const EnvironmentLight& light, const Vec3f& from, const Vec3f& direction) const;

 private:
  /** A rectangle across an axis, which light passes either way. */
  struct Opening {
    int axis = 0;
    float at = 0;       ///< on the axis
    Vec2f lower, upper; ///< on the next two axes
    float area = 0;
  };
  /** An opening that seems the smaller the better, of those that nearly all of the paths leave by. */
  static Opening fit(std::span<const LightPortals::Exit> exits);
  void divide(std::span<LightPortals::Exit> exits, const Opening& whole, int levels);

  /** Estimates of the solid angles that openings are seen in, each with those before it. */
  static constexpr int LEVELS = 4; // 2^LEVELS openings at the most: each is weighed for each shadow ray
  using SolidAngles = std::array<float, 1 << LEVELS>;
  /** Returns the sum. */
  float solidAngles(const Vec3f& point, SolidAngles& upToHere) const;
  /** Density of directions through the openings [1/sr]. */
  float pdfThrough(const SolidAngles& upToHere, const Vec3f& point, const Vec3f& direction) const;
  static constexpr std::array<float, 4> PARTS{0, 0.25f, 0.5f, 0.75f};
  /** Of light by shadow rays at vertices of camera paths, for each of PARTS. */
  struct SecondMoments {
    std::array<double, PARTS.size()> absolute{};
    std::array<double, PARTS.size()> relative{}; ///< over the square of what each path brings
  };
  SecondMoments secondMoments(const Scene& scene, TransportCounts& counts);

  std::vector<Opening> openings;
  float throughPortals = 0;
};

} // namespace recurse
