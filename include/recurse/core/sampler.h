/** @file
 * Samples: Sobol' points with hashed Owen scrambling (Burley, "Practical Hash-based Owen Scrambling", JCGT
 * 9(4), 2020), padded two dimensions at a time. A sample depends only on (seed, stream, index, dimension), so
 * that pictures do not depend on the number of threads or their order.
 */
#pragma once

#include <cstdint>

#include "recurse/core/vector.h"

namespace recurse {

/** A 64-bit mixing function (the finaliser of splitmix64, Steele et al. 2014). */
constexpr uint64_t mixBits(uint64_t v) {
  v ^= v >> 30;
  v *= 0xbf58476d1ce4e5b9ull;
  v ^= v >> 27;
  v *= 0x94d049bb133111ebull;
  return v ^ (v >> 31);
}
constexpr uint64_t hashCombine(uint64_t a, uint64_t b) { return mixBits(a * 0x9e3779b97f4a7c15ull + b + 1); }

/** A float in [0, 1) from the upper 24 bits. */
constexpr float unitFloat(uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

namespace detail {
constexpr uint32_t reverseBits(uint32_t v) {
  v = __builtin_bswap32(v);
  v = ((v >> 4) & 0x0f0f0f0fu) | ((v & 0x0f0f0f0fu) << 4);
  v = ((v >> 2) & 0x33333333u) | ((v & 0x33333333u) << 2);
  return ((v >> 1) & 0x55555555u) | ((v & 0x55555555u) << 1);
}
/** Owen scrambling of a number whose bits are reversed: each bit is flipped by a hash of the bits below it.
 */
constexpr uint32_t scrambleReversed(uint32_t v, uint32_t seed) {
  // Constants found by N. Vegdahl by optimisation for this permutation ("Building a Better LK Hash", 2021).
  v ^= v * 0x3d20adeau;
  v += seed;
  v *= (seed >> 16) | 1u;
  v ^= v * 0x05526c56u;
  v ^= v * 0x53a22864u;
  return v;
}
/** Bits of the second Sobol' dimension of a bit-reversed index: the Pascal matrix mod 2 by butterflies. */
constexpr uint32_t sobolSecondReversed(uint32_t reversedIndex) {
  uint32_t v = reversedIndex;
  v ^= (v & 0x55555555u) << 1;
  v ^= (v & 0x33333333u) << 2;
  v ^= (v & 0x0f0f0f0fu) << 4;
  v ^= (v & 0x00ff00ffu) << 8;
  v ^= (v & 0x0000ffffu) << 16;
  return v;
}
} // namespace detail

/** The samples of one light or eye path: call next1D and next2D in an order fixed by the path. Cheap to copy.
 */
class Sampler {
 public:
  /** `stream` tells pixels, and photon passes, apart; `index` counts samples of that stream. */
  Sampler(uint64_t seed, uint64_t stream, uint32_t index)
      : key(hashCombine(mixBits(seed), stream)), reversedIndex(detail::reverseBits(index)) {}

  /** In [0, 1). */
  float next1D() { return first[next()]; }
  /** In [0, 1)². */
  Vec2f next2D() {
    const unsigned i = next();
    return {first[i], second[i]};
  }
  /** An independent sampler for a branch of the path. */
  Sampler fork(uint32_t branch) const {
    Sampler s = *this;
    s.key = hashCombine(key ^ (uint64_t(dimension) << 32), branch);
    s.dimension = (dimension + AT_ONCE - 1) / AT_ONCE * AT_ONCE;
    return s;
  }

 private:
  /** Pairs of dimensions that are made together: the loops over them become vector instructions. */
  static constexpr unsigned AT_ONCE = 4;

  unsigned next() {
    const unsigned i = dimension % AT_ONCE;
    if (i == 0) refill();
    ++dimension;
    return i;
  }
  void refill() {
    // The index is shuffled within each pair of dimensions by an Owen scramble of its own.
    uint32_t shuffle[AT_ONCE], bits[2 * AT_ONCE], seeds[2 * AT_ONCE];
    for (unsigned i = 0; i < AT_ONCE; ++i) {
      const uint64_t h = mixBits(key + 0x9e3779b97f4a7c15ull * (dimension + i + 1));
      shuffle[i] = static_cast<uint32_t>(h);
      seeds[i] = static_cast<uint32_t>(h >> 32);
    }
    for (unsigned i = 0; i < AT_ONCE; ++i) {
      bits[i] = detail::scrambleReversed(reversedIndex, shuffle[i]);
      bits[AT_ONCE + i] = detail::sobolSecondReversed(bits[i]);
      seeds[AT_ONCE + i] = seeds[i] * 0x9e3779b9u + 0x7f4a7c15u;
    }
    for (unsigned i = 0; i < 2 * AT_ONCE; ++i)
      bits[i] = detail::reverseBits(detail::scrambleReversed(detail::reverseBits(bits[i]), seeds[i]));
    for (unsigned i = 0; i < AT_ONCE; ++i) {
      first[i] = unitFloat(bits[i]);
      second[i] = unitFloat(bits[AT_ONCE + i]);
    }
  }

  uint64_t key;
  uint32_t reversedIndex;
  uint32_t dimension = 0;
  float first[AT_ONCE], second[AT_ONCE]; ///< filled where dimension % AT_ONCE > 0
};

} // namespace recurse
