/** @file
 * Rays, and camera rays with the footprint of their pixel.
 */
#pragma once

#include "recurse/core/math/vector.h"

namespace recurse {

struct Ray {
  Vec3f origin;
  Vec3f direction;       ///< unit length
  float tMax = INFINITE; ///< length of the ray [scene units]
  float time = 0;        ///< in [0, 1] from the start to the end that the directive TransformTimes gives

  Vec3f at(float t) const { return origin + direction * t; }
};

/** A camera ray with its footprint: at distance t the pixel is about width + spread·t [scene units] wide. */
struct CameraRay : Ray {
  float width = 0;
  float spread = 0;
  float sampleSpacing = 1; ///< sample over pixel spacing, at least 1/8 as in pbrt; set by the renderer
  float weight = 1;        ///< factor of the radiance along the ray; 1 except for lens systems
};

} // namespace recurse
