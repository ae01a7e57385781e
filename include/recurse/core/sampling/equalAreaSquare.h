/** @file
 * Equal-area octahedral map between the unit sphere and the unit square (Clarberg 2008, "Fast Equal-Area
 * Mapping of the (Hemi)Sphere using SIMD"): a density over the square is 4π times the density per solid
 * angle.
 */
#pragma once

#include <cmath>
#include <numbers>

#include "recurse/core/math/vector.h"

namespace recurse {

/** Point of the unit square for a unit direction; +z maps to the centre. Real: float or double. */
template <class Real> glm::vec<2, Real> squareOfDirection(const glm::vec<3, Real>& d) {
  constexpr Real PI_OVER_2 = std::numbers::pi_v<Real> / 2;
  // One octant: r is the radius of a disc of equal area, and the angle runs along the diamond's edge.
  const Real r = std::sqrt((d.x * d.x + d.y * d.y) / (1 + std::abs(d.z))); // √(1 − |z|), no cancellation
  const Real part = std::atan2(std::abs(d.y), std::abs(d.x)) / PI_OVER_2;
  Real a = r * (1 - part), b = r * part;
  if (d.z < 0) {
    const Real below = 1 - b;
    b = 1 - a;
    a = below;
  }
  return {(std::copysign(a, d.x) + 1) / 2, (std::copysign(b, d.y) + 1) / 2};
}

/** Unit direction of a point of the unit square: the inverse of squareOfDirection(). */
template <class Real> glm::vec<3, Real> directionOfSquare(const glm::vec<2, Real>& point) {
  constexpr Real PI_OVER_4 = std::numbers::pi_v<Real> / 4;
  const Real u = 2 * point.x - 1, v = 2 * point.y - 1, a = std::abs(u), b = std::abs(v);
  const Real above = 1 - (a + b), r = 1 - std::abs(above);
  const Real phi = r > 0 ? PI_OVER_4 * (1 + (b - a) / r) : PI_OVER_4, s = r * std::sqrt(2 - r * r);
  return {std::copysign(s * std::cos(phi), u), std::copysign(s * std::sin(phi), v),
          std::copysign(1 - r * r, above)};
}

} // namespace recurse
