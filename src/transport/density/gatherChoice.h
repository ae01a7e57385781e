/** @file
 * Choice of the gather radius and number of photons where the user specifies none.
 */
#pragma once

#include "transport/density/gather.h"
#include "transport/density/radiusCache.h"
#include "transport/emission/cameraProbe.h"

namespace recurse {

struct GatherChoice {
  GatherSettings settings; ///< settings of the first pass
  float typicalRadius = 0; ///< median radius at visible points [scene units]; 0: unknown
};

/**
 * Chooses the search from the photons around visible points: either the k nearest photons, within a
 * limit that prevents dark corners from averaging over the whole scene, or all within the requested
 * radius. `requested`: settings of the user; a radius of 0 is chosen here, and with it a `nearest` of 0. Adds
 * the choice to the notes, and expected artifacts to the warnings. `allLight`: the map contains direct light
 * too.
 */
GatherChoice chooseGather(const Scene& scene, const PhotonMap& map, std::span<const VisiblePoint> seen,
                          const GatherSettings& requested, bool progressive, bool allLight,
                          ForwardStatistics& statistics);

} // namespace recurse
