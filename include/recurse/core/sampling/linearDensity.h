/** @file
 * Sampling of linear densities over the unit interval.
 */
#pragma once

#include <algorithm>
#include <cmath>

namespace recurse {

/** Samples x in [0, 1] from uniform u, with a density linear from a >= 0 at 0 to b >= 0 at 1; both 0: u. */
inline double sampleLinear(double u, double a, double b) {
  if (u <= 0 || !(a + b > 0)) return u; // at 0 both a and the root may be 0
  return std::min(u * (a + b) / (a + std::sqrt((1 - u) * a * a + u * b * b)), 1.0);
}

} // namespace recurse
