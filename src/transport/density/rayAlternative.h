/** @file
 * Camera rays as the alternative to photons at a place: what they cost and what they err by.
 */
#pragma once

#include "transport/direct/lightSampler.h"

namespace recurse {

/** What photons save. */
struct GatherWorth {
  /** What an estimate by photons may take at most [camera paths], to pay in the place of a ray that goes on,
   * by the variance that it saves (efficiency as in Grittmann et al. 2022, "Efficiency-Aware Multiple
   * Importance Sampling for Bidirectional Rendering Algorithms"). Infinite where nothing is known. */
  float instead = INFINITE;
  float raysVariance = 0; ///< of what one such ray estimates [W²/m⁴]
  float irradiance = 0;   ///< of the layer's photons and the direct light together [W/m²]
};

/** What camera rays would do in the place of photons. */
struct RayAlternative {
  float emitted = 0;                    ///< photons, as PhotonQuery's `merging` counts them
  const LightSampler* lights = nullptr; ///< for shadow rays; null: rays do not share light with photons
  /** What a ray finds, over all light of the place, is not weighed by more: it is found too rarely. */
  float maxBrightness = 100;
};

} // namespace recurse
