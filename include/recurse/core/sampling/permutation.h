/** @file
 * Pseudo-random permutations.
 */
#pragma once

#include <algorithm>
#include <bit>

#include "recurse/core/sampling/sampler.h"

namespace recurse {

/** Element 0 <= i < n of a pseudo-random permutation of [0, n), 1 <= n <= 2^31: a bijection of the smallest
 * power of two that is not below n, repeated until the element is below n. */
constexpr uint32_t permutedElement(uint32_t i, uint32_t n, uint64_t seed) {
  const uint32_t mask = std::bit_ceil(n) - 1;
  const int shift = std::max(1, static_cast<int>(std::bit_width(mask)) / 2);
  do {
    uint64_t hash = seed;
    for (int round = 0; round < 8; ++round) {
      hash = mixBits(hash + 0x9e3779b97f4a7c15ull);
      i = (i * (static_cast<uint32_t>(hash) | 1) + static_cast<uint32_t>(hash >> 32)) & mask;
      i ^= i >> shift;
    }
  } while (i >= n);
  return i;
}

} // namespace recurse
