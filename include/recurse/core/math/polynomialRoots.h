/** @file
 * All roots of polynomials in an interval: the Bernstein form is halved until Descartes' rule of signs leaves
 * one root (Lane and Riesenfeld, "Bounds on a Polynomial", 1981).
 */
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace recurse {

/** Coefficients of Bernstein polynomials over an interval. */
template <size_t DEGREE> using BernsteinForm = std::array<double, DEGREE + 1>;

/** Converts a polynomial, powers[k] times x^k, to the Bernstein form over x in [low, high]. */
template <size_t DEGREE>
BernsteinForm<DEGREE> bernsteinForm(const std::array<double, DEGREE + 1>& powers, double low, double high) {
  // Taylor's expansion at `low` by Horner's scheme, in units of the interval.
  std::array<double, DEGREE + 1> c = powers;
  for (size_t i = 0; i < DEGREE; ++i)
    for (size_t k = DEGREE; k-- > i;) c[k] += low * c[k + 1];
  double scale = 1;
  for (size_t k = 0; k <= DEGREE; ++k, scale *= high - low) c[k] *= scale;
  // Divided by binomial coefficients these are the forward differences of the Bernstein coefficients.
  double binomial = 1;
  for (size_t k = 0; k <= DEGREE; ++k) {
    c[k] /= binomial;
    binomial = binomial * double(DEGREE - k) / double(k + 1);
  }
  for (size_t i = 1; i <= DEGREE; ++i)
    for (size_t k = DEGREE; k >= i; --k) c[k] += c[k - 1];
  return c;
}

/** Splits the interval at a fraction of its length: `b` keeps the left part, the right part is returned. */
template <size_t DEGREE>
BernsteinForm<DEGREE> splitBernstein(BernsteinForm<DEGREE>& b, double fraction = 0.5) {
  BernsteinForm<DEGREE> right;
  for (size_t i = 0; i <= DEGREE; ++i) {
    right[DEGREE - i] = b[DEGREE];
    for (size_t k = DEGREE; k > i; --k) b[k] = (1 - fraction) * b[k - 1] + fraction * b[k];
  }
  return right;
}

/** Value of the polynomial at a fraction of the interval. */
template <size_t DEGREE> double bernsteinValue(BernsteinForm<DEGREE> b, double fraction) {
  for (size_t i = 0; i < DEGREE; ++i)
    for (size_t k = DEGREE; k > i; --k) b[k] = (1 - fraction) * b[k - 1] + fraction * b[k];
  return b[DEGREE];
}

/**
 * Calls visit(low, high, isRising) in ascending order for parts of [low, high], the interval of `b`, with one
 * sign change each. Two roots that are closer to each other than `resolution` may both be omitted. Zero
 * counts as positive.
 */
template <size_t DEGREE, class Visit>
void isolateRoots(BernsteinForm<DEGREE> b, double low, double high, double resolution, const Visit& visit) {
  int changes = 0;
  for (size_t i = 0; i < DEGREE; ++i) changes += (b[i] < 0) != (b[i + 1] < 0);
  if (changes == 0) return;
  const double middle = 0.5 * (low + high);
  if (changes == 1 || high - low <= resolution || !(middle > low && middle < high)) {
    if (changes & 1) visit(low, high, b[0] < 0);
    return;
  }
  const BernsteinForm<DEGREE> right = splitBernstein<DEGREE>(b);
  isolateRoots<DEGREE>(b, low, middle, resolution, visit);
  isolateRoots<DEGREE>(right, middle, high, resolution, visit);
}

/** Root of f in [low, high] by the Illinois method. If f has the same sign at both ends, due to rounding, the
 * result is the end with the smaller |f|. */
template <class F> double refineRoot(const F& f, double low, double high) {
  double fLow = f(low), fHigh = f(high);
  if ((fLow < 0) == (fHigh < 0)) return std::abs(fLow) < std::abs(fHigh) ? low : high; // due to rounding
  int sameSide = 0;
  for (int i = 0; i < 100; ++i) {
    // Bisects in every fourth step, for functions on which the secant converges slowly.
    double x = i % 4 == 3 ? 0.5 * (low + high) : high - fHigh * (high - low) / (fHigh - fLow);
    if (!(x > low && x < high)) x = 0.5 * (low + high);
    if (!(x > low && x < high)) break;
    const double fx = f(x);
    if (fx == 0) return x;
    if ((fx < 0) == (fHigh < 0)) {
      high = x;
      fHigh = fx;
      if (sameSide == 1) fLow *= 0.5;
      sameSide = 1;
    } else {
      low = x;
      fLow = fx;
      if (sameSide == -1) fHigh *= 0.5;
      sameSide = -1;
    }
    if (high - low <= 4e-16 * (std::abs(low) + std::abs(high))) break;
  }
  return std::abs(fLow) < std::abs(fHigh) ? low : high;
}

} // namespace recurse
