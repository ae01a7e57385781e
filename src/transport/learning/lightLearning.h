/** @file
 * Learning of the lights that reach each region, by photons and camera paths.
 */
#pragma once

#include "transport/direct/lightSampler.h"

namespace recurse {

/** Learns portals, if `withPortals`. With more than one light, also follows photons up to their first
 * non-delta surface, and camera paths from whose first such surface shadow rays find a light. Independent of
 * the seed and the number of threads. Returns the work it took. An interrupt leaves nothing learned: lights
 * are then chosen by power. */
TransportCounts learnLights(const Scene& scene, LightSampler& lights, bool withPortals = true);

} // namespace recurse
