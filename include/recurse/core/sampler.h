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
      : key(hashCombine(mixBits(seed), stream)), index(index) {}

  /** In [0, 1). */
  float next1D() {
    const uint64_t h = nextKey();
    return unitFloat(owen(shuffledReversed(h), static_cast<uint32_t>(h >> 32)));
  }
  /** In [0, 1)². */
  Vec2f next2D() {
    const uint64_t h = nextKey();
    const uint32_t reversed = shuffledReversed(h);
    const auto seed = static_cast<uint32_t>(h >> 32);
    return {unitFloat(owen(reversed, seed)),
            unitFloat(owen(detail::sobolSecondReversed(reversed), seed * 0x9e3779b9u + 0x7f4a7c15u))};
  }
  /** An independent sampler for a branch of the path. */
  Sampler fork(uint32_t branch) const {
    Sampler s = *this;
    s.key = hashCombine(key ^ (uint64_t(dimension) << 32), branch);
    return s;
  }

 private:
  uint64_t nextKey() { return mixBits(key + 0x9e3779b97f4a7c15ull * ++dimension); }
  /** The index, shuffled within this dimension by an Owen scramble of its own, as bits from the top down. */
  uint32_t shuffledReversed(uint64_t h) const {
    return detail::scrambleReversed(detail::reverseBits(index), static_cast<uint32_t>(h));
  }
  static uint32_t owen(uint32_t topDown, uint32_t seed) {
    return detail::reverseBits(detail::scrambleReversed(detail::reverseBits(topDown), seed));
  }

  uint64_t key;
  uint32_t index;
  uint32_t dimension = 0;
};

} // namespace recurse
