/** @file
 * Vectors of eight numbers: both implementations against plain arithmetic, and against each other, bit by
 * bit.
 */
#include "recurse/core/math/float8.h"

#include <array>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace recurse {
namespace {

using Eight = std::array<float, 8>;
using EightWords = std::array<uint32_t, 8>;

struct PortablePath {
  using Floats = portable::Float8;
  using Words = portable::Uint32x8;
  using Four = portable::Float4;
};
/** Implementation of the renderer: vector instructions if they were compiled in. */
struct BuiltPath {
  using Floats = Float8;
  using Words = Uint32x8;
  using Four = Float4;
};

template <class F> F floats(const Eight& x) {
  alignas(32) float aligned[8];
  std::copy(x.begin(), x.end(), aligned);
  return F::load(aligned);
}
template <class W> W words(const EightWords& x) {
  alignas(32) uint32_t aligned[8];
  std::copy(x.begin(), x.end(), aligned);
  return W::load(aligned);
}

/** Bits of the result of an operation. */
template <class T> std::vector<uint32_t> bitsOf(const T& result) {
  std::vector<uint32_t> bits(sizeof(T) / sizeof(uint32_t));
  std::memcpy(bits.data(), &result, sizeof(T));
  return bits;
}

/** Calls f(operation's name, operation): each takes three Float8 and two Uint32x8 of one path. */
template <class F> void eachOperation(F&& f) {
#define OPERATION(expression)                                                                                \
  f(#expression, [](auto a, auto b, auto c, auto m, auto n) {                                                \
    static_cast<void>(a), static_cast<void>(b), static_cast<void>(c), static_cast<void>(m),                  \
        static_cast<void>(n);                                                                                \
    return expression;                                                                                       \
  })
  OPERATION(a + b);
  OPERATION(a - b);
  OPERATION(a * b);
  OPERATION(a / b);
  OPERATION(a & b);
  OPERATION(min(a, b));
  OPERATION(max(a, b));
  OPERATION(sqrt(a));
  OPERATION(abs(a));
  OPERATION(copysign(a, b));
  OPERATION(less(a, b));
  OPERATION(lessEqual(a, b));
  OPERATION(equal(a, b));
  OPERATION(select(less(a, b), b, c));
  OPERATION(bits(a));
  OPERATION(first(a));
  OPERATION(a[5]);
  OPERATION(fromNextLane(a));
  OPERATION(least(a));
  OPERATION(sum(a));
  OPERATION(m + n);
  OPERATION(m & n);
  OPERATION(m >> 13);
  OPERATION(equal(m, n));
  OPERATION(equal(m, m & n));
  OPERATION(toFloat(m >> 1));
  OPERATION(reverseBits(m));
  OPERATION((m.countIn(lessEqual(a, b)), m));
#undef OPERATION
}

/** Replaces all NaNs by one, because sign and payload are not specified. */
std::vector<uint32_t> withOneNan(std::vector<uint32_t> bits) {
  for (uint32_t& b : bits)
    if ((b & 0x7fffffff) > 0x7f800000 && b != ~0u) b = 0x7fc00000;
  return bits;
}

TEST(Float8, bothPathsGiveTheSameBits) {
  constexpr float LARGEST = std::numeric_limits<float>::max(), SMALLEST = std::numeric_limits<float>::min();
  constexpr float INF = std::numeric_limits<float>::infinity();
  const std::vector<float> special = {0.0f, -0.0f, 1, -1, INF, -INF, LARGEST, -LARGEST, SMALLEST, NAN};
  std::mt19937 random(1);
  const auto number = [&] {
    if (random() % 3 == 0) return special[random() % special.size()];
    return std::ldexp(static_cast<float>(random()) * 0x1p-31f - 1, static_cast<int>(random() % 40) - 20);
  };
  for (int turn = 0; turn < 5000; ++turn) {
    Eight a, b, c;
    EightWords m, n;
    for (size_t i = 0; i < 8; ++i) {
      a[i] = number();
      b[i] = turn % 4 == 0 ? a[random() % (i + 1)] : number();
      c[i] = number();
      m[i] = static_cast<uint32_t>(random());
      n[i] = turn % 4 == 0 ? m[i] : static_cast<uint32_t>(random());
    }
    eachOperation([&](const char* name, auto operation) {
      const auto by = [&](auto path) {
        using Path = decltype(path);
        using F = typename Path::Floats;
        using W = typename Path::Words;
        return withOneNan(
            bitsOf(operation(floats<F>(a), floats<F>(b), floats<F>(c), words<W>(m), words<W>(n))));
      };
      EXPECT_EQ(by(BuiltPath()), by(PortablePath())) << name << ", turn " << turn;
    });
    if (HasFailure()) return;
  }
}

template <class PATH> class Lanes : public ::testing::Test {};
using Paths = ::testing::Types<BuiltPath, PortablePath>;
TYPED_TEST_SUITE(Lanes, Paths);

TYPED_TEST(Lanes, masksAndSums) {
  using F = typename TypeParam::Floats;
  const Eight x = {1, 2, 3, 4, 5, 6, 7, 8};
  const F v = floats<F>(x);
  EXPECT_EQ(sum(v), 36);
  EXPECT_EQ(least(v), 1);
  for (uint32_t mask = 0; mask < 256; ++mask) {
    EXPECT_EQ(bits(F::lanes(mask)), mask);
    float expected = 0;
    for (int i = 0; i < 8; ++i) expected += mask >> i & 1 ? x[static_cast<size_t>(i)] : 0;
    EXPECT_EQ(sum(v & F::lanes(mask)), expected);
    EXPECT_EQ(sum(select(F::lanes(mask), v, F(0))), expected);
  }
}

TYPED_TEST(Lanes, wholeNumbers) {
  using F = typename TypeParam::Floats;
  using W = typename TypeParam::Words;
  const uint8_t bytes[8] = {0, 1, 2, 127, 128, 200, 255, 1};
  uint32_t out[9] = {};
  W::fromBytes(bytes).store(out + 1);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(out[i + 1], bytes[i]);
  EXPECT_EQ(bits(equal(W::fromBytes(bytes), W(1))), 0b10000010u);
  EXPECT_EQ(first(toFloat(W(0x7fffffff))), 2147483648.0f);
  reverseBits(W(0b1101)).store(out);
  EXPECT_EQ(out[3], 0xb0000000u);
  W counts(5);
  counts.countIn(F::lanes(0b100));
  counts.store(out);
  EXPECT_EQ(out[2], 6u);
  EXPECT_EQ(out[3], 5u);
}

TYPED_TEST(Lanes, fourAtATime) {
  using Four = typename TypeParam::Four;
  alignas(16) float out[4];
  min(Four(1, -2, 3, INFINITY), Four(0)).store(out);
  EXPECT_EQ(std::vector<float>(out, out + 4), (std::vector<float>{0, -2, 0, 0}));
  max(Four::load(out), Four(-1, -1, 5, NAN)).store(out);
  EXPECT_EQ(std::vector<float>(out, out + 3), (std::vector<float>{0, -1, 5}));
  EXPECT_TRUE(std::isnan(out[3])); // the second operand, if one is NaN
}

TEST(LaneLists, namesTheLanesOfAMask) {
  for (uint32_t mask = 0; mask < 256; ++mask) {
    uint32_t up[8], down[8];
    LANE_LISTS.ascending(mask, 100, up);
    LANE_LISTS.descending(mask, 100, down);
    std::vector<uint32_t> expected;
    for (uint32_t i = 0; i < 8; ++i)
      if (mask >> i & 1) expected.push_back(100 + i);
    EXPECT_EQ(std::vector<uint32_t>(up, up + expected.size()), expected);
    EXPECT_EQ(std::vector<uint32_t>(down, down + expected.size()),
              std::vector<uint32_t>(expected.rbegin(), expected.rend()));
  }
}

} // namespace
} // namespace recurse
