/** @file
 * Default implementations of lights.
 */
#include "recurse/model/light/light.h"

namespace recurse {

Rgb Light::radianceTowards(const LeSample& sample, const Vec3f& direction) const {
  LeRay ray = sample;
  ray.direction = direction;
  if (!(pdfLe(ray).direction > 0)) return BLACK;
  if (kind() != LightKind::POINT) return sample.radiance;
  // Intensity from the radiance at a distance that dominates the origin's rounding error.
  const Vec3f place = magnitude(sample.origin);
  const float distance = std::max({1.0f, place.x, place.y, place.z});
  const std::optional<LiSample> arriving =
      sampleLiAt(sample.time, sample.origin + direction * distance, 0, Vec2f(0));
  return arriving ? arriving->radiance * square(arriving->distance) : BLACK;
}

} // namespace recurse
