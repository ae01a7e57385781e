/** @file
 * Boundary bias (Jensen 2001, section 7.2.3): a density estimate divides by the area of its kernel's support,
 * part of which reaches past the edge of a surface. Rays find the part of the kernel's weight that is
 * surface, and the estimate divides by that (Diggle 1985, "A Kernel Method for Smoothing Point Process
 * Data"), so that uniform irradiance is estimated without bias. It depends on no photon.
 */
#pragma once

#include "transport/paths/walk.h"
#include "transport/photonmap/kernel.h"
#include "transport/photonmap/photonMapQuery.h"

namespace recurse {

/** A plane beyond which there is nothing of a surface: points p with p·normal = offset. */
struct BoundaryPlane {
  enum Kind {
    WALL, ///< that rises from the surface, or ends just above it: what lies on it or behind it belongs to
          ///< another
    EDGE  ///< where the surface ends
  };
  Vec3f normal{0}; ///< unit, towards the surface
  float offset = 0;
  Kind kind = WALL;
};

/** What is known of the surface around a place. */
struct Neighbourhood {
  static constexpr size_t MAX_PLANES = GatherRegion::MAX_CLIPS;
  float reach = 0;  ///< the distance that was looked at
  float flat = 0;   ///< within this distance the surface is whole and flat, but for what lies beyond borders
  float relief = 0; ///< how far from the place's plane the surface was met within this distance
  /** How far above the place something else is; infinite where that is more than .4 of the reach. */
  float clearance = INFINITE;
  /** How far below the place another surface is, which may be lit on the same side; infinite where that is
   * more than .4 of the reach. */
  float depth = INFINITE;
  size_t planeCount = 0;
  std::array<BoundaryPlane, MAX_PLANES> planes;

  /** Whether the point is beyond no border. */
  bool sees(const Vec3f& position) const {
    return std::all_of(planes.begin(), planes.begin() + planeCount,
                       [&](const BoundaryPlane& b) { return glm::dot(position, b.normal) > b.offset; });
  }
  /** Whether nothing bounds the surface as far as that, nor is close above it. */
  bool isWholeWithin(float distance) const {
    return distance <= flat && planeCount == 0 && clearance == INFINITE;
  }
  /** Without effect where there is no more room. */
  void add(const BoundaryPlane& plane) {
    if (planeCount < MAX_PLANES) planes[planeCount++] = plane;
  }
};

/**
 * Looks around the region's centre, as far as its radius. `error` bounds that of the centre. Details that are
 * smaller than a quarter of their distance may escape it.
 */
Neighbourhood probeNeighbourhood(const Scene& scene, float error, const GatherRegion& region,
                                 Sampler& sampler, TransportCounts& counts);

/** What an estimate may know of the scene around its point. */
struct BoundaryCorrection {
  const Scene& scene;
  Sampler sampler;                      ///< for the rays that look around
  const Neighbourhood* known = nullptr; ///< of a place near by; null: nothing is known
  float away = 0;                       ///< the distance to that place
  Neighbourhood own = {};               ///< found out where nothing is known

  /** Within this distance of the point the surface is known to be flat, see Neighbourhood; else not above 0.
   */
  float flat() const { return known ? known->flat - away : 0; }
};

/** Flatter supports than this would lose photons of the surface itself. */
inline constexpr float FLATTEST = 1e-3f;

/** Of a search region of such a radius that is known to lie on a flat surface: what lies off it belongs to
 * another surface, perhaps to the lit side of a wall, or below a thin lid. No more than `most`. */
inline float flatnessOfFlat(const BoundaryCorrection& boundary, float most, float error, float radius) {
  return std::min(most, FLATTEST + (4 * boundary.known->relief + 16 * error) / radius);
}

/**
 * Clips the region at the borders around it, so that it leaves out what belongs to other surfaces or to
 * another room, and returns the part of the kernel's weight over the whole support that then lies on a
 * surface which can hold photons, measured by area on the surface: 1 on a plane, about 1/2 at an edge. A
 * support of which hardly anything is surface, whose surface bends away, or which lies in a gap of less than
 * half its radius, is made smaller first; one that would reach another surface below is made flatter. Where
 * the borders are not known the part goes by eight places: it is exact on a plane, and about .1 off
 * elsewhere.
 */
float coveredFraction(BoundaryCorrection& boundary, float error, Kernel kernel, GatherRegion& region,
                      TransportCounts& counts);

} // namespace recurse
