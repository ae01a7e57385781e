/** @file
 * Where photons are worth most, learned from trial photons before the first pass.
 */
#pragma once

#include <cstdint>
#include <vector>

#include "transport/emission/emissionGuide.h"
#include "transport/forward/shoot.h"

namespace recurse {

/** How photons are sent where they are wanted. */
struct PhotonGuidance {
  EmissionGuide emission;
  std::vector<DxtranSphere> targets;
  float splitPower = INFINITE; ///< see ShootSettings, of one photon emitted
  float minStartDensity = 0;   ///< see ShootSettings
  float sparsePart = 0;        ///< of the power where the eye looks, that starts less densely
  uint64_t useful = 0;         ///< unguided trial photons that came down where the eye looks
  double secondMoment = 0;     ///< of what a photon brings to what is seen, about; by which guidances compare
};

/** What learnGuidance() may use. */
struct GuidanceChoice {
  bool emission = true; ///< photons start where useful ones did
  bool targets = true;  ///< the region may become a target
};

/**
 * Learns from trial photons where those start that come down in the region: as few as will do, where most do
 * so anyway, and the guide is then not active. The region becomes a target where few photons come down in it
 * and many do that are sent there, as far as `choice` allows. `counts` gets what the trials cost.
 */
PhotonGuidance learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                             const ShootSettings& settings, const VisibleRegion& region,
                             const ForwardControl& control, TransportCounts& counts,
                             GuidanceChoice choice = {});

/** For light paths of which no photon map is made: where those start that come to where the eye looks. Of a
 * sun or sky outside hardly any other comes into a room. `maxDepth` as of ShootSettings; `trials`: photons of
 * a round. */
EmissionGuide learnEmissionGuide(const Scene& scene, const PathClasses& classes, uint64_t seed, int maxDepth,
                                 const ForwardControl& control, TransportCounts& counts,
                                 uint64_t trials = 32768);

} // namespace recurse
