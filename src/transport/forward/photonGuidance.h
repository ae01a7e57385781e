/** @file
 * Guidance of photons to the visible region, learned from trial photons before the first pass.
 */
#pragma once

#include <cstdint>

#include "transport/emission/emissionMixture.h"
#include "transport/emission/visibleRegion.h"
#include "transport/forward/shoot.h"

namespace recurse {

/** Guidance of photons: their starts, splitting and number. */
struct PhotonGuidance {
  EmissionMixture emission;
  float splitPower = INFINITE; ///< see ShootSettings
  double storedPhotons = 1;    ///< number of photons stored for each one emitted
};

/**
 * Learns from trial photons which emission reaches the visible region, and adds their work to `counts`. With
 * `mixes` false the lights emit by their own sampling. Without lights or a region, learns nothing.
 */
PhotonGuidance learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                             const ShootSettings& settings, const VisibleRegion& region,
                             const ForwardControl& control, TransportCounts& counts, bool mixes);

/** Learns emission for light paths without a photon map: the starts of paths that reach the visible region.
 * Few other paths from an outdoor sun or sky enter a room. `maxDepth`: see ShootSettings; `trials`: number of
 * photons in a round. */
EmissionMixture learnEmission(const Scene& scene, const PathClasses& classes, uint64_t seed, int maxDepth,
                              const ForwardControl& control, TransportCounts& counts,
                              uint64_t trials = 32768);

} // namespace recurse
