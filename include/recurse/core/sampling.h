/** @file
 * Warps of uniform numbers onto discs, spheres and cones.
 */
#pragma once

#include "recurse/core/vector.h"

namespace recurse {

/** Uniform on the unit disc by the concentric map (Shirley, Chiu 1997), which keeps stratification. */
inline Vec2f uniformDisk(const Vec2f& u) {
  const Vec2f o = u * 2.0f - 1.0f;
  if (o.x == 0 && o.y == 0) return {0, 0};
  if (std::abs(o.x) > std::abs(o.y)) {
    const float theta = PI / 4 * (o.y / o.x);
    return Vec2f(std::cos(theta), std::sin(theta)) * o.x;
  }
  const float theta = PI / 2 - PI / 4 * (o.x / o.y);
  return Vec2f(std::cos(theta), std::sin(theta)) * o.y;
}

/** Around +z with density cos/π (Malley's method). */
inline Vec3f cosineHemisphere(const Vec2f& u) {
  const Vec2f d = uniformDisk(u);
  return {d.x, d.y, std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y))};
}

/** With density 1/(4π). */
inline Vec3f uniformSphere(const Vec2f& u) {
  const float z = 1 - 2 * u.x;
  const float r = std::sqrt(std::max(0.0f, 1 - z * z));
  const float phi = 2 * PI * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

} // namespace recurse
