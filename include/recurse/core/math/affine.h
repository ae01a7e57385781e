/** @file
 * Tests whether a matrix can be a transform of shapes or cameras: finite and invertible.
 */
#pragma once

#include <cmath>

#include "recurse/core/math/vector.h"

namespace recurse {

inline bool isFinite(const Mat4d& m) {
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r)
      if (!std::isfinite(m[c][r])) return false;
  return true;
}

/** True for a non-singular linear part; columns are normalised first, to prevent underflow. */
inline bool isInvertible(const Mat4d& m) {
  Mat3d linear(m);
  for (int c = 0; c < 3; ++c) {
    const double size = std::max({std::abs(linear[c].x), std::abs(linear[c].y), std::abs(linear[c].z)});
    if (!(size > 0)) return false;
    linear[c] /= size;
  }
  // Below this threshold the columns are dependent to all digits that a file could have.
  return std::abs(glm::determinant(linear)) > 1e-14;
}

} // namespace recurse
