/** @file
 * Interval arithmetic in double precision (Moore, "Interval Analysis", 1966): bounds of functions that hold
 * in spite of rounding.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "recurse/core/math/vector.h"

namespace recurse {

/** Range of a function. It is empty where the function is undefined everywhere. */
struct Interval {
  double low = 0, high = 0;
  bool isPartial = false; ///< the function may be undefined, or jump, somewhere

  constexpr Interval() = default;
  constexpr explicit Interval(double x) : low(x), high(x) {}
  constexpr Interval(double low, double high, bool isPartial = false)
      : low(low), high(high), isPartial(isPartial) {}
  static constexpr Interval undefined() { return {INFINITE_D, -INFINITE_D, true}; }

  bool isEmpty() const { return !(low <= high); }
  bool contains(double x) const { return low <= x && x <= high; }
  double width() const { return high - low; }
};

/** The interval with its bounds moved outwards by `units` times 2^-52 of their magnitude. */
inline Interval roundedOut(double low, double high, bool isPartial, double units = 1) {
  constexpr double LARGEST = std::numeric_limits<double>::max();
  low = std::min(low, LARGEST);
  high = std::max(high, -LARGEST);
  const double factor = units * 0x1p-52;
  return {low - std::abs(low) * factor, high + std::abs(high) * factor, isPartial};
}

inline Interval hull(const Interval& a, const Interval& b) {
  return {std::min(a.low, b.low), std::max(a.high, b.high), a.isPartial || b.isPartial};
}

inline Interval operator-(const Interval& a) { return {-a.high, -a.low, a.isPartial}; }
inline Interval operator+(const Interval& a, const Interval& b) {
  if (a.isEmpty() || b.isEmpty()) return Interval::undefined();
  return roundedOut(a.low + b.low, a.high + b.high, a.isPartial || b.isPartial);
}
inline Interval operator-(const Interval& a, const Interval& b) { return a + -b; }

/** Product of bounds: 0 times infinity is 0, as an infinite bound is not attained. */
inline double productOfBounds(double a, double b) { return a == 0 || b == 0 ? 0 : a * b; }

inline Interval operator*(const Interval& a, const Interval& b) {
  if (a.isEmpty() || b.isEmpty()) return Interval::undefined();
  double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
  if (!std::isfinite(p + q + r + s)) {
    p = productOfBounds(a.low, b.low), q = productOfBounds(a.low, b.high);
    r = productOfBounds(a.high, b.low), s = productOfBounds(a.high, b.high);
  }
  return roundedOut(std::min(std::min(p, q), std::min(r, s)), std::max(std::max(p, q), std::max(r, s)),
                    a.isPartial || b.isPartial);
}

/** 1 / a. A range that only touches 0 has one infinite bound. */
inline Interval reciprocal(const Interval& a) {
  if (a.isEmpty() || (a.low == 0 && a.high == 0)) return Interval::undefined();
  if (a.low < 0 && a.high > 0) return {-INFINITE_D, INFINITE_D, true};
  return roundedOut(a.high == 0 ? -INFINITE_D : 1 / a.high, a.low == 0 ? INFINITE_D : 1 / a.low,
                    a.isPartial || a.low == 0 || a.high == 0);
}
inline Interval operator/(const Interval& a, const Interval& b) { return a * reciprocal(b); }

inline Interval minimum(const Interval& a, const Interval& b) {
  if (a.isEmpty() || b.isEmpty()) return Interval::undefined();
  return {std::min(a.low, b.low), std::min(a.high, b.high), a.isPartial || b.isPartial};
}
inline Interval maximum(const Interval& a, const Interval& b) { return -minimum(-a, -b); }

inline Interval absolute(const Interval& a) {
  if (a.isEmpty() || a.low >= 0) return a;
  return a.high <= 0 ? -a : Interval(0, std::max(-a.low, a.high), a.isPartial);
}

/** Bound on the error of functions of the standard library [units of 2^-52]. */
constexpr double LIBRARY_UNITS = 4;

inline Interval squareRoot(const Interval& a) {
  if (!(a.high >= 0)) return Interval::undefined();
  return roundedOut(std::sqrt(std::max(a.low, 0.0)), std::sqrt(a.high), a.isPartial || a.low < 0);
}

inline Interval exponential(const Interval& a) {
  if (a.isEmpty()) return a;
  return roundedOut(std::exp(a.low), std::exp(a.high), a.isPartial, LIBRARY_UNITS);
}

inline Interval logarithm(const Interval& a) {
  if (!(a.high >= 0)) return Interval::undefined();
  return roundedOut(std::log(std::max(a.low, 0.0)), std::log(a.high), a.isPartial || a.low <= 0,
                    LIBRARY_UNITS);
}

/** Sine of a plus a quarter of a turn times `quarters`. */
inline Interval sineAt(const Interval& a, int quarters) {
  if (a.isEmpty()) return a;
  constexpr double QUARTER = 1.57079632679489661923, TURN = 4 * QUARTER;
  const double slack = 0x1p-50 * (8 + std::max(std::abs(a.low), std::abs(a.high)));
  if (!(a.width() < TURN) || !(slack < 1)) return {-1, 1, a.isPartial};
  // Whether a crest of the sine is in the interval: at (1 - quarters) quarters, modulo whole turns.
  const auto has = [&](int crest) {
    const double at = (crest - quarters) * QUARTER;
    return at + TURN * std::ceil((a.low - slack - at) / TURN) <= a.high + slack;
  };
  const double p = quarters ? std::cos(a.low) : std::sin(a.low),
               q = quarters ? std::cos(a.high) : std::sin(a.high);
  const Interval ends = roundedOut(std::min(p, q), std::max(p, q), a.isPartial, LIBRARY_UNITS);
  return {has(-1) ? -1 : std::max(ends.low, -1.0), has(1) ? 1 : std::min(ends.high, 1.0), a.isPartial};
}
inline Interval sine(const Interval& a) { return sineAt(a, 0); }
inline Interval cosine(const Interval& a) { return sineAt(a, 1); }

/** x to the power n >= 0 by repeated squaring. */
inline double wholePower(double x, int n) {
  double power = 1;
  for (; n > 0; n >>= 1, x *= x)
    if (n & 1) power *= x;
  return power;
}

/** a to the power n. */
inline Interval power(const Interval& a, int n) {
  if (n < 0) return reciprocal(power(a, -n));
  if (a.isEmpty()) return a;
  double low = wholePower(a.low, n), high = wholePower(a.high, n);
  if (n % 2 == 0) {
    if (a.high <= 0) std::swap(low, high);
    if (a.low < 0 && a.high > 0) {
      high = std::max(low, high);
      low = n == 0 ? 1 : 0;
    }
  }
  return roundedOut(low, high, a.isPartial, 2.0 * n);
}

/** a to a power that is no integer, defined for a >= 0. */
inline Interval power(const Interval& a, double exponent) {
  if (!(a.high >= 0)) return Interval::undefined();
  const double base = std::max(a.low, 0.0);
  const double p = std::pow(base, exponent), q = std::pow(a.high, exponent);
  return roundedOut(std::min(p, q), std::max(p, q), a.isPartial || a.low < 0 || (exponent < 0 && a.low <= 0),
                    LIBRARY_UNITS);
}

} // namespace recurse
