/** @file
 * Exits: vertices where camera paths leave the scene, such as points on the panes of a window, and crossings
 * of the last segments of such paths, such as points in a hole of a wall. Light of infinite lights enters
 * the scene there.
 */
#pragma once

#include <vector>

#include "recurse/transport/integrator/integrator.h"

namespace recurse {

/** Minimum number of positions of camera paths that represent the openings of a scene. Groups of as many are
 * divided into halves. More than MANY_POSITIONS do not improve the boxes and rectangles around them. */
constexpr size_t ENOUGH_POSITIONS = 64, MANY_POSITIONS = 8 * ENOUGH_POSITIONS;
/** Margin around positions, relative to their extent: openings are wider than the paths through them. */
constexpr float POSITION_MARGIN = 0.05f;

/** Point through which environment light may enter: the last vertex of a camera path that leaves the scene,
 * or a crossing of the last segments of such paths. */
struct CameraExit {
  Vec3f position;
  float weight;    ///< throughput of the path, at most 1
  Vec3f direction; ///< unit; (0, 0, 0) towards a distant light
  float along = 0; ///< distance from the last vertex [scene units]
};

/** Crossings of camera paths that leave the scene; their last vertices if too few cross; empty if too few
 * paths leave. The number of paths follows the pixels of the film, so that the time remains small. */
std::vector<CameraExit> exitCrossings(const Scene& scene, uint64_t seed, TransportCounts& counts);

/** Last vertices and crossings of camera paths that leave the scene, by scattering or by a shadow ray to a
 * distant light. Empty without infinite lights, or if too few paths leave. */
std::vector<CameraExit> exitsAndCrossings(const Scene& scene, uint64_t seed, TransportCounts& counts);

} // namespace recurse
