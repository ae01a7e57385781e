/** @file
 * Integrals of smooth functions of one variable.
 */
#pragma once

#include <cmath>

namespace recurse {

/** Gauss-Legendre quadrature with seven points on [a, b]. */
template <class F> double gauss7(const F& f, double a, double b) {
  constexpr double NODE[] = {0, 0.4058451513773972, 0.7415311855993945, 0.9491079123427585},
                   WEIGHT[] = {0.4179591836734694, 0.3818300505051189, 0.2797053914892766,
                               0.1294849661688697};
  const double centre = 0.5 * (a + b), half = 0.5 * (b - a);
  double sum = WEIGHT[0] * f(centre);
  for (int i = 1; i < 4; ++i) sum += WEIGHT[i] * (f(centre - half * NODE[i]) + f(centre + half * NODE[i]));
  return sum * half;
}

/** Adaptive quadrature: halves [a, b] until the sum of both halves differs from `whole`, gauss7() of [a, b],
 * by at most `tolerance` (absolute, and half as much in each half), or `depth` + 1 times. */
template <class F>
double integrate(const F& f, double a, double b, double tolerance, double whole, int depth) {
  const double middle = 0.5 * (a + b);
  const double left = gauss7(f, a, middle), right = gauss7(f, middle, b);
  if (depth == 0 || !(std::abs(left + right - whole) > tolerance)) return left + right;
  return integrate(f, a, middle, 0.5 * tolerance, left, depth - 1) +
         integrate(f, middle, b, 0.5 * tolerance, right, depth - 1);
}
/** Adaptive quadrature with a tolerance relative to gauss7() of [a, b], and up to 31 halvings. For
 * functions of one sign: where parts cancel, f may be called 3e10 times. The result is NaN where a value is.
 */
template <class F> double integrate(const F& f, double a, double b, double relativeTolerance) {
  const double whole = gauss7(f, a, b);
  return integrate(f, a, b, relativeTolerance * std::abs(whole), whole, 30);
}

} // namespace recurse
