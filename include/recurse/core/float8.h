/** @file
 * Eight floats at a time, by AVX2.
 */
#pragma once

#include <cstdint>

#include <immintrin.h>

#ifndef __AVX2__
#error "Recurse needs AVX2: build for x86-64-v3 or later"
#endif

namespace recurse {

/** Eight floats in a register. Comparisons give a bit mask, bit i for lane i. */
struct Float8 {
  __m256 v;

  Float8() = default;
  Float8(__m256 v) : v(v) {}
  Float8(float x) : v(_mm256_set1_ps(x)) {}
  /** From 8 floats on a 32-byte boundary. */
  static Float8 load(const float* p) { return _mm256_load_ps(p); }
  void store(float* p) const { _mm256_store_ps(p, v); }
  /** All bits set in the lanes of the mask. */
  static Float8 lanes(uint32_t mask) {
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    const __m256i on = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(mask)), bit);
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(on, bit));
  }
  float operator[](int lane) const {
    alignas(32) float x[8];
    store(x);
    return x[lane];
  }

  friend Float8 operator+(Float8 a, Float8 b) { return _mm256_add_ps(a.v, b.v); }
  friend Float8 operator-(Float8 a, Float8 b) { return _mm256_sub_ps(a.v, b.v); }
  friend Float8 operator*(Float8 a, Float8 b) { return _mm256_mul_ps(a.v, b.v); }
  friend Float8 operator/(Float8 a, Float8 b) { return _mm256_div_ps(a.v, b.v); }
  friend Float8 operator&(Float8 a, Float8 b) { return _mm256_and_ps(a.v, b.v); }
  Float8& operator+=(Float8 b) { return *this = *this + b; }
  friend Float8 min(Float8 a, Float8 b) { return _mm256_min_ps(a.v, b.v); }
  friend Float8 max(Float8 a, Float8 b) { return _mm256_max_ps(a.v, b.v); }
  friend Float8 sqrt(Float8 a) { return _mm256_sqrt_ps(a.v); }
  friend Float8 abs(Float8 a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v); }
  friend Float8 copysign(Float8 a, Float8 b) {
    const __m256 sign = _mm256_set1_ps(-0.0f);
    return _mm256_or_ps(_mm256_andnot_ps(sign, a.v), _mm256_and_ps(sign, b.v));
  }
  /** a where the bits of `lanes` are set, otherwise b. */
  friend Float8 select(Float8 lanes, Float8 a, Float8 b) { return _mm256_blendv_ps(b.v, a.v, lanes.v); }
  friend Float8 less(Float8 a, Float8 b) { return _mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ); }
  friend Float8 lessEqual(Float8 a, Float8 b) { return _mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ); }
  friend Float8 equal(Float8 a, Float8 b) { return _mm256_cmp_ps(a.v, b.v, _CMP_EQ_OQ); }
  /** The sign bits as a mask. */
  friend uint32_t bits(Float8 a) { return static_cast<uint32_t>(_mm256_movemask_ps(a.v)); }
  friend float least(Float8 a) {
    const __m128 four = _mm_min_ps(_mm256_castps256_ps128(a.v), _mm256_extractf128_ps(a.v, 1));
    const __m128 two = _mm_min_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)));
  }
  /** The sum of the lanes, in a fixed order. */
  friend float sum(Float8 a) {
    const __m128 four = _mm_add_ps(_mm256_castps256_ps128(a.v), _mm256_extractf128_ps(a.v, 1));
    const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)));
  }
};

/** Eight vectors. */
struct Vec3f8 {
  Float8 x, y, z;
};

/** For each mask of eight lanes the lanes in it, packed; what comes after them is of no account. */
struct LaneLists {
  alignas(64) uint8_t lanes[256][8] = {};
  alignas(64) uint8_t lanesDown[256][8] = {};

  constexpr LaneLists() {
    for (int mask = 0; mask < 256; ++mask) {
      int up = 0, down = 0;
      for (int i = 0; i < 8; ++i) {
        if (mask >> i & 1) lanes[mask][up++] = static_cast<uint8_t>(i);
        if (mask >> (7 - i) & 1) lanesDown[mask][down++] = static_cast<uint8_t>(7 - i);
      }
    }
  }
  /** Writes base + lane for every lane in the mask, and something up to the eighth place. */
  void ascending(uint32_t mask, uint32_t base, uint32_t* out) const { write(lanes[mask], base, out); }
  void descending(uint32_t mask, uint32_t base, uint32_t* out) const { write(lanesDown[mask], base, out); }

 private:
  static void write(const uint8_t* list, uint32_t base, uint32_t* out) {
    const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(list));
    const __m256i sum =
        _mm256_add_epi32(_mm256_cvtepu8_epi32(bytes), _mm256_set1_epi32(static_cast<int>(base)));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), sum);
  }
};
inline constexpr LaneLists LANE_LISTS;

} // namespace recurse
