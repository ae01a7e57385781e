/** @file
 * Camera rays as the alternative to photons at a point: their cost and their error.
 */
#pragma once

#include "transport/direct/lightSampler.h"

namespace recurse {

/** Gain of a density estimate over rays. */
struct GatherBenefit {
  /** Maximum cost [camera paths] at which a photon estimate is more efficient than a ray that continues,
   * given the variance that it saves (efficiency as in Grittmann et al. 2022, "Efficiency-Aware Multiple
   * Importance Sampling for Bidirectional Rendering Algorithms"). Infinite if unknown. */
  float maxCost = INFINITE;
  float raysVariance = 0; ///< variance of the estimate by one such ray [W²/m⁴]
  float irradiance = 0;   ///< irradiance by the layer's photons and direct light [W/m²]
};

/** Model of camera rays that replace photons. */
struct RayAlternative {
  float emitted = 0;                    ///< number of photons emitted in the pass
  const LightSampler* lights = nullptr; ///< for shadow rays; null: rays do not share light with photons
  /** Maximum of a ray's estimate over the irradiance at the point: larger ones are too rare to count. */
  float maxBrightness = 100;
};

} // namespace recurse
