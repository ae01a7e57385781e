/** @file
 * Camera rays as the alternative to photons at a point.
 */
#pragma once

#include "transport/direct/lightSampler.h"

namespace recurse {

/** Model of camera rays that replace photons. */
struct RayAlternative {
  float emitted = 0;                    ///< number of photons emitted in the pass
  const LightSampler* lights = nullptr; ///< for shadow rays; null: rays do not share light with photons
  /** Maximum of a ray's estimate over the irradiance at the point: larger ones are too rare to count. */
  float maxBrightness = 100;
};

} // namespace recurse
