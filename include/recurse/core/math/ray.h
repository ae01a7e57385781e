/** @file
 * Rays, with the width of the pixel that they carry along.
 */
#pragma once

#include "recurse/core/math/vector.h"

namespace recurse {

struct Ray {
  Vec3f origin;
  Vec3f direction; ///< unit length
  float tMax = INFINITE;
  float time = 0; ///< in [0, 1] from the scene's first transforms to its last; see TransformTimes

  Vec3f at(float t) const { return origin + direction * t; }
};

/** A ray from the eye with its footprint: at distance t the pixel is about width + spread·t across. */
struct CameraRay : Ray {
  float width = 0;
  float spread = 0;
  float sampleSpacing = 1; ///< distance between the samples of a pixel over that between pixels
  float weight = 1;        ///< of the radiance that the ray brings: 1 but for lens systems
};

} // namespace recurse
