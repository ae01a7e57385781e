/** @file
 * Sums whose bits do not depend on the order.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "recurse/core/math/longSum.h"

using recurse::LongSum;

namespace {

/** Products of two floats over a range of `powers` powers of two, with both signs. */
std::vector<double> products(int powers, int count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> mantissa(-2, 2);
  std::uniform_int_distribution<int> exponent(-powers / 2, powers / 2);
  std::vector<double> out;
  for (int i = 0; i < count; ++i)
    out.push_back(double(mantissa(random)) * double(std::ldexp(mantissa(random), exponent(random))));
  return out;
}

/** Nearest double of a sum, and nearest double of the remainder. */
std::pair<double, double> bothParts(LongSum sum) {
  const double high = sum;
  sum += -high;
  return {high, sum};
}

} // namespace

TEST(LongSum, OrderAndGroupingDoNotMatter) {
  bool plainDiffers = false;
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    std::vector<double> values = products(30, 3000, seed);
    LongSum forward;
    double plain = 0;
    for (const double x : values) {
      forward += x;
      plain += x;
    }
    std::mt19937 random(seed);
    for (int round = 0; round < 10; ++round) {
      std::shuffle(values.begin(), values.end(), random);
      std::vector<LongSum> groups(size_t(round) + 1);
      double plainSum = 0;
      for (const double x : values) {
        groups[random() % groups.size()] += x;
        plainSum += x;
      }
      LongSum all;
      for (const LongSum& g : groups) all += g;
      ASSERT_EQ(bothParts(all), bothParts(forward)) << "seed " << seed << " round " << round;
      plainDiffers = plainDiffers || plainSum != plain;
    }
  }
  EXPECT_TRUE(plainDiffers) << "doubles would do as well: this proves nothing";
}

TEST(LongSum, KeepsWhatADoubleLoses) {
  LongSum sum;
  sum += 0x1p60;
  for (int i = 0; i < 1000; ++i) sum += 0x1p-20;
  sum += -0x1p60;
  EXPECT_EQ(double(sum), 1000 * 0x1p-20);
}
