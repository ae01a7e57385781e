/** @file
 * Pictures with known noise.
 */
#pragma once

#include <random>

#include "recurse/core/image/image.h"

namespace recurse {

/** Adds normally distributed, independent noise to every value. */
inline Image noisy(const Image& truth, double deviation, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0, deviation);
  Image out = truth;
  for (float& value : out.pixels) value += static_cast<float>(normal(generator));
  return out;
}

} // namespace recurse
