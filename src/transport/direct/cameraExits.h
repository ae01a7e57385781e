/** @file
 * Exits: vertices where camera paths leave the scene, such as points on the panes of a window, and crossings
 * of the last segments of such paths, such as points in a hole of a wall. Light of infinite lights enters
 * the scene there.
 */
#pragma once

#include "recurse/core/math/nestedBoxes.h"
#include "recurse/transport/integrator/integrator.h"

namespace recurse {

/** Points through which light of infinite lights may enter, on camera paths that leave the scene. Vertices
 * alone would enclose a whole room with a wide window, and crossings alone may be far outside of a small
 * one. */
struct CameraExits {
  std::vector<WeightedPosition> vertices;  ///< last vertices; empty if too few paths leave
  std::vector<WeightedPosition> crossings; ///< crossings of last segments; empty if too few cross
};

/** Follows at most 4 `resolution`² camera paths. They leave by scattering and, if `towardsDistant`, by a
 * shadow ray to a distant light at each vertex. */
CameraExits findExits(const Scene& scene, bool towardsDistant, int resolution, uint64_t seed,
                      TransportCounts& counts);

/** Thickness of boxes around exits in one plane, such as a pane [scene units]. */
inline float flatness(const Scene& scene) { return 1e-5f * scene.bounds().radius; }

} // namespace recurse
