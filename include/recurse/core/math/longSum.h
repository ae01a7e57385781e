/** @file
 * Sums whose result does not depend on the order of the terms.
 */
#pragma once

namespace recurse {

/**
 * Sum as an unevaluated pair of doubles (Dekker 1971; two-sum by Knuth, TAOCP 2, 4.2.2), which holds 106
 * bits. Floats, products of two floats and squares of floats have at most 48 bits. Their sums are exact, and
 * hence the same for any order and grouping, while n times the largest of n terms is less than 2^58 times the
 * smallest that is not zero; beyond that, each addition is rounded by at most 2^-103 of its larger operand.
 */
class LongSum {
 public:
  LongSum& operator+=(double x) {
    const Pair sum = twoSum(high, x);
    return *this = normalized(sum.value, low + sum.error);
  }
  LongSum& operator+=(const LongSum& o) {
    const Pair highs = twoSum(high, o.high), lows = twoSum(low, o.low);
    const LongSum sum = normalized(highs.value, highs.error + lows.value);
    return *this = normalized(sum.high, sum.low + lows.error);
  }
  /** The nearest double. */
  operator double() const { return high; } // NOLINT: a sum is used as a number

 private:
  struct Pair {
    double value, error;
  };
  /** Error-free transformation: a + b = value + error. */
  static Pair twoSum(double a, double b) {
    const double value = a + b, ofB = value - a;
    return {value, (a - (value - ofB)) + (b - ofB)};
  }
  static LongSum normalized(double a, double b) {
    const Pair sum = twoSum(a, b);
    LongSum out;
    out.high = sum.value;
    out.low = sum.error;
    return out;
  }
  double high = 0, low = 0;
};

} // namespace recurse
