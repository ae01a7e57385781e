/** @file
 * Weights between density estimation and BSDF sampling at a rough lobe. A photon map is accurate for a
 * broad lobe; few photons are inside of a sharp one and cause blotches, which a BSDF-sampled ray avoids.
 * Both weights depend only on the two directions and sum to one, so that no light is counted twice or
 * lost.
 */
#pragma once

#include <cmath>

#include "recurse/core/math/vector.h"

namespace recurse {

struct GatherWeighting {
  /** Density of BSDF sampling at which both weights are 1/2 [1/sr]. A roughness alpha is converted to the
   * peak density of a metal's lobe at normal incidence: 1 / (4 π alpha²). */
  float density = INFINITE;

  static GatherWeighting belowRoughness(double alpha) {
    return {alpha > 0 ? static_cast<float>(1 / (4 * M_PI * alpha * alpha)) : INFINITE};
  }
  bool ever() const { return density < INFINITE; }
  /** Weight of the ray whose direction the BSDF samples with density `pdf` [1/sr]. It rises from 0 at half of
   * `density` to 1 at twice of it. No ray is needed where it is 0, no photon where it is 1. */
  float followed(float pdf) const {
    if (!(pdf > 0.5f * density)) return 0;
    if (pdf >= 2 * density) return 1;
    const float t = 0.5f + 0.5f * std::log2(pdf / density);
    return t * t * (3 - 2 * t);
  }
  /** Weight of the photons. */
  float gathered(float pdf) const { return 1 - followed(pdf); }
};

} // namespace recurse
