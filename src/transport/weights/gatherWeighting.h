/** @file
 * Who takes the light at a rough lobe into account: the photon map, or a ray that follows the lobe. A map is
 * good where a lobe is broad; of a sharp lobe the few photons that lie within it make blotches, which one ray
 * along it does not. Both weights depend on nothing but the two directions and add up to one, so that nothing
 * is counted twice and nothing is left out.
 */
#pragma once

#include <algorithm>
#include <cmath>

#include "recurse/core/math/vector.h"

namespace recurse {

struct GatherWeighting {
  /** The density [1/sr] at which both have one half; a roughness is that of the metal whose lobe, seen from
   * the normal, has this density in its middle: 1 / (4 π alpha²). */
  float density = INFINITE;

  static GatherWeighting belowRoughness(double alpha) {
    return {alpha > 0 ? static_cast<float>(1 / (4 * M_PI * alpha * alpha)) : INFINITE};
  }
  bool ever() const { return density < INFINITE; }
  /** The weight of the ray, whose direction the BSDF chooses with density `pdf` [1/sr]. It rises from 0 at
   * half of `density` to 1 at twice of it: where it is 0 no ray is needed, where it is 1 no photon. */
  float followed(float pdf) const {
    if (!(pdf > 0.5f * density)) return 0;
    if (pdf >= 2 * density) return 1;
    const float t = 0.5f + 0.5f * std::log2(pdf / density);
    return t * t * (3 - 2 * t);
  }
  /** The weight of the photons. */
  float gathered(float pdf) const { return 1 - followed(pdf); }
};

} // namespace recurse
