/** @file
 * Pictures with noise that is known.
 */
#pragma once

#include <random>

#include "recurse/core/image/image.h"

namespace recurse {

/** Normally distributed, independent in every value. */
inline Image noisy(const Image& truth, double deviation, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0, deviation);
  Image out = truth;
  for (float& value : out.pixels) value += static_cast<float>(normal(generator));
  return out;
}

} // namespace recurse
