/** @file
 * Guidance of photons to the visible region, learned from trial photons before the first pass.
 */
#pragma once

#include <cstdint>

#include "transport/emission/emissionGuide.h"
#include "transport/forward/shoot.h"

namespace recurse {

/** Guidance of photons: their starts, splitting and number. */
struct PhotonGuidance {
  EmissionGuide emission;
  float splitPower = INFINITE; ///< see ShootSettings; for a single photon emitted [W]
  double storedPhotons = 1;    ///< number of photons stored for each one emitted
};

/** Result of trial photons without a guide. */
struct StartTrial {
  uint64_t useful = 0;     ///< number of photons stored in the visible region
  double secondMoment = 0; ///< approximate second moment of a photon's visible contribution
};

/** Shoots trial photons by the starts of `settings`, and adds their work to `counts`. */
StartTrial tryStarts(const Scene& scene, const PathClasses& classes, uint64_t seed,
                     const ShootSettings& settings, const VisibleRegion& region, TransportCounts& counts);

/**
 * Learns from trial photons which starts reach the visible region. The trials are few, and the guide is
 * inactive, where most photons reach it anyway, or without `guidesEmission`. Adds the work of the trials to
 * `counts`.
 */
PhotonGuidance learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                             const ShootSettings& settings, const VisibleRegion& region,
                             const ForwardControl& control, TransportCounts& counts,
                             bool guidesEmission = true);

/** Learns an emission guide for light paths without a photon map: the starts of paths that reach the visible
 * region. Few other paths from an outdoor sun or sky enter a room. `maxDepth`: see ShootSettings; `trials`:
 * number of photons in a round. */
EmissionGuide learnEmissionGuide(const Scene& scene, const PathClasses& classes, uint64_t seed, int maxDepth,
                                 const ForwardControl& control, TransportCounts& counts,
                                 uint64_t trials = 32768);

} // namespace recurse
