/** @file
 * Sampling of environment lights through windows, doors and holes that camera paths have found, compare the
 * portal lights of pbrt-v4. The mixture with the light's own sampling also finds light through other
 * openings.
 */
#pragma once

#include <array>
#include <span>
#include <vector>

#include "transport/direct/cameraExits.h"

namespace recurse {

class PortalSampler {
 public:
  /** Learns portals and the mixture weight that minimises the second moment of direct light at camera
   * vertices. The weight is 0 if the gain is small. It is 1/4 if sunlight on a few paths dominates the moment
   * and hides a large gain of most others. Returns the work it took. */
  TransportCounts learn(const Scene& scene);
  /** Mixture weight of the portals, in [0, 1); 0: no portals. */
  float probability() const { return throughPortals; }
  bool active() const { return throughPortals > 0; }

  /** Mixture of portals and the light's own sampling, as in EnvironmentLight; independent of time. */
  std::optional<LiSample> sampleLi(const EnvironmentLight& light, const Vec3f& point, float pick,
                                   const Vec2f& u) const;
  float pdfLi(const EnvironmentLight& light, const Vec3f& from, const Vec3f& direction) const;

 private:
  /** Rectangle perpendicular to an axis, which light passes in both directions. */
  struct Opening {
    int axis = 0;
    float at = 0;       ///< coordinate on the axis
    Vec2f lower, upper; ///< corners on the next two axes
    float area = 0;
  };
  /** Smallest tested opening that nearly all of the paths leave through. */
  static Opening fit(std::span<const CameraExit> exits);
  void divide(std::span<CameraExit> exits, const Opening& whole, int levels);

  static constexpr int LEVELS = 4; // at most 2^LEVELS openings, as each shadow ray evaluates all
  /** Cumulative sums of the estimated solid angles of the openings [sr]. */
  using SolidAngles = std::array<float, 1 << LEVELS>;
  /** Computes the cumulative sums for a point, and returns the total [sr]. */
  float solidAngles(const Vec3f& point, SolidAngles& upToHere) const;
  /** Density of directions through the openings [1/sr]. */
  float pdfThrough(const SolidAngles& upToHere, const Vec3f& point, const Vec3f& direction) const;
  static constexpr std::array<float, 4> PARTS{0, 0.25f, 0.5f, 0.75f};
  /** Second moments of direct light by shadow rays at camera vertices, for each mixture weight of PARTS. */
  struct SecondMoments {
    std::array<double, PARTS.size()> absolute{};
    std::array<double, PARTS.size()> relative{}; ///< divided by the squared radiance of each path
  };
  SecondMoments secondMoments(const Scene& scene, TransportCounts& counts) const;

  std::vector<Opening> openings;
  float throughPortals = 0;
};

} // namespace recurse
