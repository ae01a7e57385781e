/** @file
 * How samples are made: eight numbers at once, by vector instructions that compilers do not find by
 * themselves.
 */
#include "recurse/core/sampler.h"

#include <immintrin.h>

namespace recurse {

namespace {

// Vector extensions of GCC and Clang: operators work on each number.
using Words = uint32_t __attribute__((vector_size(32)));
using HalfWords = uint32_t __attribute__((vector_size(16)));
using Longs = uint64_t __attribute__((vector_size(32)));

/** Each number's bits in the opposite order. */
Words reverseBits(Words v) {
  const __m256i bytes = _mm256_broadcastsi128_si256(
      _mm_set_epi8(12, 13, 14, 15, 8, 9, 10, 11, 4, 5, 6, 7, 0, 1, 2, 3)); // of each word, reversed
  const __m256i low = _mm256_broadcastsi128_si256(
      _mm_set_epi8(15, 7, 11, 3, 13, 5, 9, 1, 14, 6, 10, 2, 12, 4, 8, 0)); // reversed in four bits
  const __m256i high = _mm256_slli_epi16(low, 4), four = _mm256_set1_epi8(15);
  const __m256i swapped = _mm256_shuffle_epi8((__m256i)v, bytes);
  return (Words)_mm256_or_si256(
      _mm256_shuffle_epi8(high, _mm256_and_si256(swapped, four)),
      _mm256_shuffle_epi8(low, _mm256_and_si256(_mm256_srli_epi16(swapped, 4), four)));
}

/** Owen scrambling of numbers whose bits are reversed: each bit is flipped by a hash of the bits below it. */
template <class T> T scrambleReversed(T v, T seed) {
  // Constants found by N. Vegdahl by optimisation for this permutation ("Building a Better LK Hash", 2021).
  v ^= v * 0x3d20adeau;
  v += seed;
  v *= (seed >> 16) | 1u;
  v ^= v * 0x05526c56u;
  v ^= v * 0x53a22864u;
  return v;
}

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

} // namespace

void Sampler::refill() {
  const Longs hashes = mixBits(key + 0x9e3779b97f4a7c15ull * (dimension + Longs{1, 2, 3, 4}));
  const Words halves = __builtin_shufflevector((Words)hashes, (Words)hashes, 0, 2, 4, 6, 1, 3, 5, 7);
  const auto shuffle = __builtin_shufflevector(halves, halves, 0, 1, 2, 3);
  const auto seeds = __builtin_shufflevector(halves, halves, 4, 5, 6, 7);
  // The index is shuffled within each pair of dimensions by an Owen scramble of its own.
  const HalfWords shuffled = scrambleReversed(reversedIndex + HalfWords{}, shuffle);
  Words bits = both(shuffled, sobolSecondReversed(shuffled));
  bits = scrambleReversed(reverseBits(bits), both(seeds, seeds * 0x9e3779b9u + 0x7f4a7c15u));
  // As unitFloat().
  static_assert(sizeof numbers == sizeof bits);
  _mm256_storeu_ps(numbers, _mm256_mul_ps(_mm256_cvtepi32_ps((__m256i)(reverseBits(bits) >> 8)),
                                          _mm256_set1_ps(0x1p-24f)));
}

} // namespace recurse
