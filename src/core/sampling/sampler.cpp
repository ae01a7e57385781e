/** @file
 * Generation of samples: eight numbers at once.
 */
#include "recurse/core/sampling/sampler.h"

#include "recurse/core/math/float8.h"

#include <cstring>

namespace recurse {

namespace {

// Vector extensions of GCC and Clang, whose operators apply to each element.
using Words = uint32_t __attribute__((vector_size(32)));
using HalfWords = uint32_t __attribute__((vector_size(16)));
using Longs = uint64_t __attribute__((vector_size(32)));

Words reverseBits(Words v) { return std::bit_cast<Words>(reverseBits(std::bit_cast<Uint32x8>(v))); }

/** Bits of the second Sobol' dimension of a bit-reversed index: the Pascal matrix mod 2 by butterflies. */
HalfWords sobolSecondReversed(HalfWords v) {
  v ^= (v & 0x55555555u) << 1;
  v ^= (v & 0x33333333u) << 2;
  v ^= (v & 0x0f0f0f0fu) << 4;
  v ^= (v & 0x00ff00ffu) << 8;
  v ^= (v & 0x0000ffffu) << 16;
  return v;
}

Words both(HalfWords a, HalfWords b) { return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7); }

/** Sobol' points of shuffled and bit-reversed indices, with Owen scrambling by `seeds`. */
void sobolPairs(HalfWords reversedIndices, HalfWords seeds, float* numbers) {
  Words bits = both(reversedIndices, sobolSecondReversed(reversedIndices));
  bits = scrambleReversed(reverseBits(bits), both(seeds, seeds * 0x9e3779b9u + 0x7f4a7c15u));
  // Conversion to [0, 1) as in unitFloat().
  static_assert(sizeof bits == 2 * SamplePoints::PAIRS * sizeof(float));
  const Float8 unit = toFloat(std::bit_cast<Uint32x8>(reverseBits(bits) >> 8)) * Float8(0x1p-24f);
  std::memcpy(numbers, &unit, sizeof unit);
}

} // namespace

void SamplePoints::fillSobol(const Pairs& reversedIndices, const Pairs& seeds, float* numbers) {
  sobolPairs(std::bit_cast<HalfWords>(reversedIndices), std::bit_cast<HalfWords>(seeds), numbers);
}

void Sampler::refill() {
  if (points) return points->fill(key, reverseBits(reversedIndex), dimension, numbers);
  // The hashes are those of SamplePoints::pairHash().
  const Longs hashes = mixBits(key + 0x9e3779b97f4a7c15ull * (dimension + Longs{1, 2, 3, 4}));
  const Words halves = __builtin_shufflevector((Words)hashes, (Words)hashes, 0, 2, 4, 6, 1, 3, 5, 7);
  const auto shuffle = __builtin_shufflevector(halves, halves, 0, 1, 2, 3);
  const auto seeds = __builtin_shufflevector(halves, halves, 4, 5, 6, 7);
  // The index is shuffled by an Owen scramble of its own for each pair of dimensions.
  sobolPairs(scrambleReversed(reversedIndex + HalfWords{}, shuffle), seeds, numbers);
}

} // namespace recurse
