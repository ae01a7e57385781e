/** @file
 * Warps of uniform samples, u in [0, 1)², to discs, spheres and cones.
 */
#pragma once

#include "recurse/core/math/vector.h"

namespace recurse {

/** (cos x, sin x) for |x| <= pi/4, to float precision, by truncated Taylor series. */
inline Vec2f cosSinSmall(float x) {
  const float x2 = x * x;
  return {1 + x2 * (-1.0f / 2 + x2 * (1.0f / 24 + x2 * (-1.0f / 720 + x2 * (1.0f / 40320)))),
          x * (1 + x2 * (-1.0f / 6 + x2 * (1.0f / 120 + x2 * (-1.0f / 5040 + x2 * (1.0f / 362880)))))};
}

/** Uniform point of the unit disc by the concentric map (Shirley, Chiu 1997), which keeps stratification. */
inline Vec2f uniformDisk(const Vec2f& u) {
  const Vec2f o = u * 2.0f - 1.0f;
  if (o.x == 0 && o.y == 0) return {0, 0};
  // Selections instead of branches, which could not be predicted.
  const bool alongX = std::abs(o.x) > std::abs(o.y);
  const float radius = alongX ? o.x : o.y;
  const Vec2f c = cosSinSmall(PI / 4 * ((alongX ? o.y : o.x) / radius)) * radius;
  return {alongX ? c.x : c.y, alongX ? c.y : c.x};
}

/** arctan x for |x| <= 1, to 2e-7 rad: Chebyshev fit of odd powers. */
inline float atanSmall(float x) {
  const float x2 = x * x;
  return x *
         (0.999999984f +
          x2 * (-0.333330668f +
                x2 * (0.199924836f +
                      x2 * (-0.142025705f +
                            x2 * (0.106367541f + x2 * (-0.074954454f +
                                                       x2 * (0.042587607f + x2 * (-0.016005030f +
                                                                                  x2 * (0.002834064f)))))))));
}

/** Inverse of uniformDisk() for points of the disc; result in [0, 1)². */
inline Vec2f squareOfDisk(const Vec2f& d) {
  const bool alongX = std::abs(d.x) > std::abs(d.y);
  const float along = alongX ? d.x : d.y, across = alongX ? d.y : d.x;
  if (along == 0) return {0.5f, 0.5f};
  const float radius = std::copysign(std::sqrt(d.x * d.x + d.y * d.y), along);
  const float other = radius * atanSmall(across / along) * (4 / PI);
  return glm::clamp((Vec2f(alongX ? radius : other, alongX ? other : radius) + 1.0f) * 0.5f, 0.0f,
                    ONE_MINUS_EPSILON);
}

/** Direction around +z with density cos/π [1/sr] (Malley's method). */
inline Vec3f cosineHemisphere(const Vec2f& u) {
  const Vec2f d = uniformDisk(u);
  return {d.x, d.y, std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y))};
}

/** Uniform direction in a cone around +z with density 1 / (2π opening) [1/sr]; `opening`, in (0, 2], is 1 −
 * the cosine of the half-angle. */
inline Vec3f uniformCone(const Vec2f& u, float opening) {
  const float below = u.x * opening, r = std::sqrt(below * (2 - below)), phi = 2 * PI * u.y;
  return {r * std::cos(phi), r * std::sin(phi), 1 - below};
}

/** Uniform direction with density 1/(4π) [1/sr]. */
inline Vec3f uniformSphere(const Vec2f& u) {
  const float z = 1 - 2 * u.x;
  const float r = std::sqrt(std::max(0.0f, 1 - z * z));
  const float phi = 2 * PI * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

} // namespace recurse
