/** @file
 * Samples: Sobol' points with hashed Owen scrambling (Burley, "Practical Hash-based Owen Scrambling", JCGT
 * 9(4), 2020), padded two dimensions at a time, or the points of a plug-in. A sample depends only on (seed,
 * stream, index, planned samples, dimension) and on the parameters of the plug-in, so that images do not
 * depend on the number or the order of threads.
 */
#pragma once

#include <array>
#include <cstdint>

#include "recurse/core/math/vector.h"

namespace recurse {

/** 64-bit mixing function (the finaliser of splitmix64, Steele et al. 2014) of an unsigned number or of each
 * component of a vector. */
template <class T>
requires(sizeof(T) >= sizeof(uint64_t)) constexpr T mixBits(T v) {
  v ^= v >> 30;
  v *= 0xbf58476d1ce4e5b9ull;
  v ^= v >> 27;
  v *= 0x94d049bb133111ebull;
  return v ^ (v >> 31);
}
constexpr uint64_t hashCombine(uint64_t a, uint64_t b) { return mixBits(a * 0x9e3779b97f4a7c15ull + b + 1); }

/** A float in [0, 1) from the upper 24 bits. */
constexpr float unitFloat(uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

/** Reverses the bits. */
constexpr uint32_t reverseBits(uint32_t v) {
  v = __builtin_bswap32(v);
  v = ((v >> 4) & 0x0f0f0f0fu) | ((v & 0x0f0f0f0fu) << 4);
  v = ((v >> 2) & 0x33333333u) | ((v & 0x33333333u) << 2);
  return ((v >> 1) & 0x55555555u) | ((v & 0x55555555u) << 1);
}

/** Owen scrambling of numbers whose bits are reversed: each bit is flipped by a hash of the bits below it. */
template <class T> constexpr T scrambleReversed(T v, T seed) {
  // Constants found by N. Vegdahl by optimisation for this permutation ("Building a Better LK Hash", 2021).
  v ^= v * 0x3d20adeau;
  v += seed;
  v *= (seed >> 16) | 1u;
  v ^= v * 0x05526c56u;
  v ^= v * 0x53a22864u;
  return v;
}

/** Points of samples. A Sampler without one has the Sobol' points. */
class SamplePoints {
 public:
  virtual ~SamplePoints() = default;

  /** Number of pairs of dimensions computed together. */
  static constexpr unsigned PAIRS = 4;
  using Pairs = std::array<uint32_t, PAIRS>;

  /** Sets numbers[i] and numbers[PAIRS + i], for i < PAIRS, to the two dimensions of pair `first + i` of
   * sample `index`, in [0, 1). `index` is the one given to the Sampler, and so is `key`, except that each
   * fork has another. */
  virtual void fill(uint64_t key, uint32_t index, uint32_t first, float* numbers) const = 0;

  /** Hash of a pair of dimensions, independent for each key and each pair. */
  static constexpr uint64_t pairHash(uint64_t key, uint32_t pair) {
    return mixBits(key + 0x9e3779b97f4a7c15ull * (pair + uint64_t(1)));
  }
  /** Fills `numbers`, as fill() does, with Sobol' points. For each pair: the index with its bits reversed,
   * and the seed of its Owen scrambling. */
  static void fillSobol(const Pairs& reversedIndices, const Pairs& seeds, float* numbers);
};

/** Samples of one light or camera path: call next1D and next2D in an order that the path determines. Cheap to
 * copy. */
class Sampler {
 public:
  /** `stream` distinguishes pixels and photon passes; `index` counts the samples of that stream. */
  Sampler(uint64_t seed, uint64_t stream, uint32_t index)
      : key(hashCombine(mixBits(seed), stream)), reversedIndex(reverseBits(index)) {}

  /** Sample `index` of the sequence `key` of the points of a plug-in, which must outlive the sampler. */
  Sampler(const SamplePoints& points, uint64_t key, uint32_t index)
      : key(key), reversedIndex(reverseBits(index)), points(&points) {}

  /** Next sample in [0, 1). Consumes a pair of dimensions, whose second is not used. */
  float next1D() { return numbers[next()]; }
  /** Next sample in [0, 1)². */
  Vec2f next2D() {
    const unsigned i = next();
    return {numbers[i], numbers[AT_ONCE + i]};
  }
  /** Independent sampler for a branch of the path. */
  Sampler fork(uint32_t branch) const {
    Sampler s = *this;
    s.key = hashCombine(key ^ (uint64_t(dimension) << 32), branch);
    s.dimension = (dimension + AT_ONCE - 1) / AT_ONCE * AT_ONCE;
    return s;
  }

 private:
  static constexpr unsigned AT_ONCE = SamplePoints::PAIRS;

  unsigned next() {
    const unsigned i = dimension % AT_ONCE;
    if (i == 0) refill();
    ++dimension;
    return i;
  }
  void refill();

  uint64_t key;
  uint32_t reversedIndex;
  uint32_t dimension = 0;               ///< number of pairs of dimensions used
  float numbers[2 * AT_ONCE];           ///< valid where dimension % AT_ONCE > 0
  const SamplePoints* points = nullptr; ///< null: Sobol' points
};

} // namespace recurse
