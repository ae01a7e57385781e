/** @file
 * SIMD of eight lanes: by AVX2, or by plain code for any processor, with bit-identical results. No other code
 * uses intrinsics.
 */
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#if defined(__AVX2__) || defined(__SSE__)
#include <immintrin.h>
#endif

namespace recurse {

/**
 * Portable lanes, in loops that compilers may vectorise. These loops define the operations: `avx2` has the
 * same names and gives the same bits.
 */
namespace portable {

/** Four floats. */
struct Float4 {
  alignas(16) float v[4];

  Float4() = default;
  Float4(float x) : v{x, x, x, x} {}
  Float4(float x, float y, float z, float w) : v{x, y, z, w} {}
  /** Loads 4 floats from a 16-byte boundary; store() needs one too. */
  static Float4 load(const float* p) { return {p[0], p[1], p[2], p[3]}; }
  void store(float* p) const { std::copy(v, v + 4, p); }

  friend Float4 min(Float4 a, Float4 b) {
    for (int i = 0; i < 4; ++i) a.v[i] = a.v[i] < b.v[i] ? a.v[i] : b.v[i];
    return a;
  }
  friend Float4 max(Float4 a, Float4 b) {
    for (int i = 0; i < 4; ++i) a.v[i] = a.v[i] > b.v[i] ? a.v[i] : b.v[i];
    return a;
  }
};

/** Eight floats. A mask of lanes is a Float8 too, with all bits of a lane set or none. */
struct Float8 {
  alignas(32) float v[8];

  Float8() = default;
  Float8(float x) { std::fill(v, v + 8, x); }
  /** Loads 8 floats from a 32-byte boundary; store() needs one too. */
  static Float8 load(const float* p) {
    return eachLane([&](int i) { return p[i]; });
  }
  void store(float* p) const { std::copy(v, v + 8, p); }
  /** Mask of lanes: lane i has all bits set where bit i of `mask` is. */
  static Float8 lanes(uint32_t mask) {
    return eachLane([&](int i) { return allBits(mask >> i & 1); });
  }
  float operator[](int lane) const { return v[lane]; }

  friend Float8 operator+(const Float8& a, const Float8& b) {
    return eachLane([&](int i) { return a.v[i] + b.v[i]; });
  }
  friend Float8 operator-(const Float8& a, const Float8& b) {
    return eachLane([&](int i) { return a.v[i] - b.v[i]; });
  }
  friend Float8 operator*(const Float8& a, const Float8& b) {
    return eachLane([&](int i) { return a.v[i] * b.v[i]; });
  }
  friend Float8 operator/(const Float8& a, const Float8& b) {
    return eachLane([&](int i) { return a.v[i] / b.v[i]; });
  }
  /** Bitwise and. */
  friend Float8 operator&(const Float8& a, const Float8& b) {
    return eachLane([&](int i) { return fromBits(toBits(a.v[i]) & toBits(b.v[i])); });
  }
  Float8& operator+=(const Float8& b) { return *this = *this + b; }
  /** Smaller number of each lane; b where either is NaN, or where both are zero; likewise max(). */
  friend Float8 min(const Float8& a, const Float8& b) {
    return eachLane([&](int i) { return a.v[i] < b.v[i] ? a.v[i] : b.v[i]; });
  }
  friend Float8 max(const Float8& a, const Float8& b) {
    return eachLane([&](int i) { return a.v[i] > b.v[i] ? a.v[i] : b.v[i]; });
  }
  friend Float8 sqrt(const Float8& a) {
    return eachLane([&](int i) { return std::sqrt(a.v[i]); });
  }
  friend Float8 abs(const Float8& a) {
    return eachLane([&](int i) { return std::abs(a.v[i]); });
  }
  friend Float8 copysign(const Float8& a, const Float8& b) {
    return eachLane([&](int i) { return std::copysign(a.v[i], b.v[i]); });
  }
  /** Selects a in the given lanes, b elsewhere. */
  friend Float8 select(const Float8& lanes, const Float8& a, const Float8& b) {
    return eachLane([&](int i) { return toBits(lanes.v[i]) >> 31 ? a.v[i] : b.v[i]; });
  }
  friend Float8 less(const Float8& a, const Float8& b) {
    return eachLane([&](int i) { return allBits(a.v[i] < b.v[i]); });
  }
  friend Float8 lessEqual(const Float8& a, const Float8& b) {
    return eachLane([&](int i) { return allBits(a.v[i] <= b.v[i]); });
  }
  friend Float8 equal(const Float8& a, const Float8& b) {
    return eachLane([&](int i) { return allBits(a.v[i] == b.v[i]); });
  }
  /** Sign bits, bit i for lane i; inverse of lanes() for a mask of lanes. */
  friend uint32_t bits(const Float8& a) {
    uint32_t mask = 0;
    for (int i = 0; i < 8; ++i) mask |= toBits(a.v[i]) >> 31 << i;
    return mask;
  }
  friend float first(const Float8& a) { return a.v[0]; }
  /** Shifts lanes down by one: each lane takes the number of its successor, and lane 7 keeps its own. */
  friend Float8 fromNextLane(const Float8& a) {
    return eachLane([&](int i) { return a.v[std::min(i + 1, 7)]; });
  }
  /** Smallest of the lanes; unspecified where one is NaN. */
  friend float least(const Float8& a) {
    const Float4 four = min(Float4::load(a.v), Float4::load(a.v + 4));
    const float even = four.v[0] < four.v[2] ? four.v[0] : four.v[2];
    const float odd = four.v[1] < four.v[3] ? four.v[1] : four.v[3];
    return even < odd ? even : odd;
  }
  /** Sum of the lanes, in a fixed order. */
  friend float sum(const Float8& a) {
    const auto across = [&](int i) { return a.v[i] + a.v[i + 4]; };
    return across(0) + across(2) + (across(1) + across(3));
  }

 private:
  static uint32_t toBits(float x) { return std::bit_cast<uint32_t>(x); }
  static float fromBits(uint32_t x) { return std::bit_cast<float>(x); }
  static float allBits(bool set) { return fromBits(set ? ~0u : 0u); }
  template <class F> static Float8 eachLane(F&& f) {
    Float8 r;
    for (int i = 0; i < 8; ++i) r.v[i] = f(i);
    return r;
  }
};

/** Eight unsigned integers of 32 bits. */
struct Uint32x8 {
  alignas(32) uint32_t v[8];

  Uint32x8() = default;
  Uint32x8(uint32_t x) { std::fill(v, v + 8, x); }
  /** Loads 8 numbers from a 32-byte boundary. */
  static Uint32x8 load(const uint32_t* p) {
    return eachLane([&](int i) { return p[i]; });
  }
  /** Widens 8 bytes. */
  static Uint32x8 fromBytes(const uint8_t* p) {
    return eachLane([&](int i) { return p[i]; });
  }
  /** Stores to any address, aligned or not. */
  void store(uint32_t* p) const { std::copy(v, v + 8, p); }

  friend Uint32x8 operator+(const Uint32x8& a, const Uint32x8& b) {
    return eachLane([&](int i) { return a.v[i] + b.v[i]; });
  }
  friend Uint32x8 operator&(const Uint32x8& a, const Uint32x8& b) {
    return eachLane([&](int i) { return a.v[i] & b.v[i]; });
  }
  friend Uint32x8 operator>>(const Uint32x8& a, int places) {
    return eachLane([&](int i) { return a.v[i] >> places; });
  }
  /** Adds one in the given lanes. */
  void countIn(const Float8& lanes) {
    const uint32_t mask = bits(lanes);
    for (int i = 0; i < 8; ++i) v[i] += mask >> i & 1;
  }
  /** Mask of the lanes in which both numbers are equal. */
  friend Float8 equal(const Uint32x8& a, const Uint32x8& b) {
    uint32_t mask = 0;
    for (int i = 0; i < 8; ++i) mask |= uint32_t(a.v[i] == b.v[i]) << i;
    return Float8::lanes(mask);
  }
  /** Conversion of numbers below 2^31. */
  friend Float8 toFloat(const Uint32x8& a) {
    Float8 r;
    for (int i = 0; i < 8; ++i) r.v[i] = static_cast<float>(a.v[i]);
    return r;
  }
  /** Reverses the bits of each number. */
  friend Uint32x8 reverseBits(const Uint32x8& a) {
    return eachLane([&](int i) {
      uint32_t x = a.v[i];
      x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
      x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
      x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
      return __builtin_bswap32(x);
    });
  }

 private:
  template <class F> static Uint32x8 eachLane(F&& f) {
    Uint32x8 r;
    for (int i = 0; i < 8; ++i) r.v[i] = f(i);
    return r;
  }
};

} // namespace portable

#ifdef __AVX2__
/** AVX2 implementation of `portable`. */
namespace avx2 {

struct Float4 {
  __m128 v;

  Float4() = default;
  Float4(__m128 v) : v(v) {}
  Float4(float x) : v(_mm_set1_ps(x)) {}
  Float4(float x, float y, float z, float w) : v(_mm_setr_ps(x, y, z, w)) {}
  static Float4 load(const float* p) { return _mm_load_ps(p); }
  void store(float* p) const { _mm_store_ps(p, v); }

  friend Float4 min(Float4 a, Float4 b) { return _mm_min_ps(a.v, b.v); }
  friend Float4 max(Float4 a, Float4 b) { return _mm_max_ps(a.v, b.v); }
};

struct Float8 {
  __m256 v;

  Float8() = default;
  Float8(__m256 v) : v(v) {}
  Float8(float x) : v(_mm256_set1_ps(x)) {}
  static Float8 load(const float* p) { return _mm256_load_ps(p); }
  void store(float* p) const { _mm256_store_ps(p, v); }
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
  friend Float8 select(Float8 lanes, Float8 a, Float8 b) { return _mm256_blendv_ps(b.v, a.v, lanes.v); }
  friend Float8 less(Float8 a, Float8 b) { return _mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ); }
  friend Float8 lessEqual(Float8 a, Float8 b) { return _mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ); }
  friend Float8 equal(Float8 a, Float8 b) { return _mm256_cmp_ps(a.v, b.v, _CMP_EQ_OQ); }
  friend uint32_t bits(Float8 a) { return static_cast<uint32_t>(_mm256_movemask_ps(a.v)); }
  friend float first(Float8 a) { return _mm256_cvtss_f32(a.v); }
  friend Float8 fromNextLane(Float8 a) {
    return _mm256_permutevar8x32_ps(a.v, _mm256_setr_epi32(1, 2, 3, 4, 5, 6, 7, 7));
  }
  friend float least(Float8 a) {
    const __m128 four = _mm_min_ps(_mm256_castps256_ps128(a.v), _mm256_extractf128_ps(a.v, 1));
    const __m128 two = _mm_min_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)));
  }
  friend float sum(Float8 a) {
    const __m128 four = _mm_add_ps(_mm256_castps256_ps128(a.v), _mm256_extractf128_ps(a.v, 1));
    const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)));
  }
};

struct Uint32x8 {
  __m256i v;

  Uint32x8() = default;
  Uint32x8(__m256i v) : v(v) {}
  Uint32x8(uint32_t x) : v(_mm256_set1_epi32(static_cast<int>(x))) {}
  static Uint32x8 load(const uint32_t* p) { return _mm256_load_si256(reinterpret_cast<const __m256i*>(p)); }
  static Uint32x8 fromBytes(const uint8_t* p) {
    return _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)));
  }
  void store(uint32_t* p) const { _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), v); }

  friend Uint32x8 operator+(Uint32x8 a, Uint32x8 b) { return _mm256_add_epi32(a.v, b.v); }
  friend Uint32x8 operator&(Uint32x8 a, Uint32x8 b) { return _mm256_and_si256(a.v, b.v); }
  friend Uint32x8 operator>>(Uint32x8 a, int places) { return _mm256_srli_epi32(a.v, places); }
  void countIn(Float8 lanes) { v = _mm256_sub_epi32(v, _mm256_castps_si256(lanes.v)); } // all bits are -1
  friend Float8 equal(Uint32x8 a, Uint32x8 b) { return _mm256_castsi256_ps(_mm256_cmpeq_epi32(a.v, b.v)); }
  friend Float8 toFloat(Uint32x8 a) { return _mm256_cvtepi32_ps(a.v); }
  friend Uint32x8 reverseBits(Uint32x8 a) {
    const __m256i bytes = _mm256_broadcastsi128_si256(
        _mm_set_epi8(12, 13, 14, 15, 8, 9, 10, 11, 4, 5, 6, 7, 0, 1, 2, 3)); // reversed bytes of each word
    const __m256i low = _mm256_broadcastsi128_si256(
        _mm_set_epi8(15, 7, 11, 3, 13, 5, 9, 1, 14, 6, 10, 2, 12, 4, 8, 0)); // 4-bit values, bits reversed
    const __m256i high = _mm256_slli_epi16(low, 4), four = _mm256_set1_epi8(15);
    const __m256i swapped = _mm256_shuffle_epi8(a.v, bytes);
    return _mm256_or_si256(_mm256_shuffle_epi8(high, _mm256_and_si256(swapped, four)),
                           _mm256_shuffle_epi8(low, _mm256_and_si256(_mm256_srli_epi16(swapped, 4), four)));
  }
};

} // namespace avx2
using namespace avx2;
#else
using namespace portable;
#endif

/** Makes this thread treat denormal floats as zero, where the processor can: they are slow, and no
 * computation needs them. */
inline void flushDenormals() {
#ifdef __SSE__
  constexpr unsigned FLUSH_ZERO = 0x8000, DENORMALS_ARE_ZERO = 0x0040;
  _mm_setcsr(_mm_getcsr() | FLUSH_ZERO | DENORMALS_ARE_ZERO);
#endif
}

/** Eight vectors, one in each lane. */
struct Vec3f8 {
  Float8 x, y, z;
};

/** Indices of the set lanes for each of the 256 masks, ascending in `lanes`, descending in `lanesDown`; later
 * entries are unspecified. */
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
  /** Writes base + lane for each set lane, ascending; of the 8 entries written, the last are unspecified. */
  void ascending(uint32_t mask, uint32_t base, uint32_t* out) const { write(lanes[mask], base, out); }
  void descending(uint32_t mask, uint32_t base, uint32_t* out) const { write(lanesDown[mask], base, out); }

 private:
  static void write(const uint8_t* list, uint32_t base, uint32_t* out) {
    (Uint32x8::fromBytes(list) + Uint32x8(base)).store(out);
  }
};
inline constexpr LaneLists LANE_LISTS;

} // namespace recurse
