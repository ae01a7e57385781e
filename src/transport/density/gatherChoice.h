/** @file
 * How far a photon map is searched where the user does not say.
 */
#pragma once

#include "transport/density/gather.h"
#include "transport/density/radiusCache.h"
#include "transport/emission/cameraProbe.h"

namespace recurse {

struct GatherChoice {
  GatherSettings settings; ///< of the first pass
  float typicalRadius = 0; ///< where the eye looks
};

/**
 * Looks at the photons where the eye does, and settles the search: the k nearest photons, within a limit
 * that keeps dark corners from smearing over the whole scene; or all within the radius that was asked for.
 * `requested`: what the user asked for; 0 photons, or a radius of 0, leave it open. What is chosen goes to
 * the notes, and what will be wrong with the picture to the warnings. `allLight`: the map has direct light,
 * too.
 */
GatherChoice chooseGather(const Scene& scene, const PhotonMap& map, std::span<const VisiblePoint> seen,
                          const GatherSettings& requested, bool progressive, bool allLight,
                          LightDetail detail, ForwardStatistics& statistics);

} // namespace recurse
