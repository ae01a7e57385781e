/** @file
 * Boundary bias (Jensen 2001, section 7.2.3): a density estimate divides by the area of its kernel support,
 * part of which may extend past the edge of a surface. Rays estimate the fraction of the kernel's weight that
 * is on the surface, and the estimate divides by it (Diggle 1985, "A Kernel Method for Smoothing Point
 * Process Data"), so that uniform irradiance is estimated without bias. The fraction does not depend on
 * photons.
 */
#pragma once

#include "transport/paths/walk.h"
#include "transport/photonmap/kernel.h"
#include "transport/photonmap/photonMapQuery.h"

namespace recurse {

/** Plane that bounds a surface: points p with p·normal = offset. The surface is on its positive side. */
struct BoundaryPlane {
  enum Kind {
    WALL, ///< a wall that rises from the surface, or ends just above it: points on it or behind it belong to
          ///< a different surface
    EDGE  ///< an edge at which the surface ends
  };
  Vec3f normal{0}; ///< unit, towards the surface
  float offset = 0;
  Kind kind = WALL;
};

/** Geometry of the surface around a point, as found by probe rays. */
struct Neighbourhood {
  static constexpr size_t MAX_PLANES = GatherRegion::MAX_CLIPS;
  float reach = 0;  ///< distance up to which rays have probed [scene units]
  float flat = 0;   ///< radius in which the surface is flat and ends only at `planes`; 0: unknown
  float relief = 0; ///< maximum distance of the surface from the tangent plane within `flat`
  /** Height of the nearest surface above the point that casts a shadow, which clear glass does not; infinite
   * if it is more than heightKnown(). */
  float clearance = INFINITE;
  /** Least depth of a second surface, which may be lit on the same side, below the point or below surface
   * points near by; infinite if it is more than heightKnown(). */
  float depth = INFINITE;
  size_t planeCount = 0;
  std::array<BoundaryPlane, MAX_PLANES> planes;

  /** Distance up to which geometry above and below was searched. */
  float heightKnown() const { return 0.4f * reach; }
  /** Whether the position is on the surface's side of all planes. */
  bool sees(const Vec3f& position) const {
    return std::all_of(planes.begin(), planes.begin() + planeCount,
                       [&](const BoundaryPlane& b) { return glm::dot(position, b.normal) > b.offset; });
  }
  /** Adds a plane; ignored if the array is full. */
  void add(const BoundaryPlane& plane) {
    if (planeCount < MAX_PLANES) planes[planeCount++] = plane;
  }
};

/**
 * Probes the surface around the region's centre up to the region's radius. `error`: bound of the centre's
 * position error. Geometry smaller than half of its distance may be missed.
 */
Neighbourhood probeNeighbourhood(const Scene& scene, float error, const GatherRegion& region,
                                 Sampler& sampler, TransportCounts& counts);

/** Geometry around the point of a density estimate, as far as it is known. coveredFraction() probes the
 * rest. */
struct BoundaryCorrection {
  const Scene& scene;
  Sampler sampler;                      ///< random numbers of the probe rays
  const Neighbourhood* known = nullptr; ///< geometry around a point near by; null: nothing is known
  float away = 0;                       ///< distance to that point [scene units]
  Neighbourhood probed = {};            ///< result of such probes, which `known` then points to

  /** Radius around the point in which the surface is flat, see Neighbourhood; at most 0: unknown. */
  float flat() const { return known ? known->flat - away : 0; }
};

/** Minimum flatness: flatter supports would lose photons of the surface itself. */
inline constexpr float FLATTEST = 1e-3f;

/** Flatness of a search region with this radius on a surface known to be flat, at most `most`. `error`: bound
 * of the centre's position error. boundary.known must not be null. Photons off the plane belong to a
 * different surface, perhaps to the lit side of a wall, or below a thin lid. */
inline float flatnessOfFlat(const BoundaryCorrection& boundary, float most, float error, float radius) {
  return std::min(most, FLATTEST + (4 * boundary.known->relief + 16 * error) / radius);
}

/**
 * Clips the region at the planes around it, so that it excludes photons of other surfaces or of a different
 * room. Returns the fraction of the kernel's weight over the whole support that is then on a surface which
 * can hold photons, measured by area on the surface: 1 on a plane, about 1/2 at an edge; never 0, and 1 if
 * probes find no surface. A support is reduced first if very little of it is surface, if its surface bends
 * away, or if it is in a gap of less than half its radius below a surface that casts a shadow. It is
 * flattened if it would reach a different surface below. Where the surface is not known to be flat, the
 * fraction is estimated at eight points (16 once reduced): exact on a plane, about .1 off elsewhere.
 * `error`: bound of the centre's position error.
 */
float coveredFraction(BoundaryCorrection& boundary, float error, Kernel kernel, GatherRegion& region,
                      TransportCounts& counts);

} // namespace recurse
