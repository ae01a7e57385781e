/** @file
 * Kernels of density estimation: weight of a photon as a function of its distance from the query point.
 *
 * Kernel K(d) [1/area] with a disc of radius r as its support, normalised there: ∫ K(d) 2πd dd = 1 over [0,
 * r]. A uniform irradiance field is estimated without bias wherever the disc is within the surface. Kernels
 * are defined by their shape π r² K over q = d²/r², since photon-map queries yield squared distances.
 */
#pragma once

#include <cmath>

#include "recurse/core/math/vector.h"

namespace recurse {

enum class Kernel {
  CONSTANT,    ///< K = 1 / (π r²): least noise for a given number of photons, sharp borders
  CONE,        ///< K = 3 (1 − d/r) / (π r²): Jensen's filter with k = 1
  EPANECHNIKOV ///< K = 2 (1 − d²/r²) / (π r²): least mean squared error (Silverman 1986, section 3.3.2)
};

/**
 * Kernel shape π r² K at q = d²/r², for 0 <= q <= 1 (negative or undefined beyond). T is float, double or
 * Float8. The kernel is a template argument, so that inner loops have no branch on it.
 */
template <Kernel KERNEL, class T> T kernelShape(const T& q) {
  using std::sqrt;
  if constexpr (KERNEL == Kernel::CONSTANT) {
    return T(1);
  } else if constexpr (KERNEL == Kernel::CONE) {
    return T(3) * (T(1) - sqrt(q));
  } else {
    return T(2) * (T(1) - q);
  }
}

/** Integral of the kernel over a narrow sector up to q = d²/r²: ∫ π r² K dq from 0 to q. */
template <Kernel KERNEL, class T> T kernelPart(const T& q) {
  using std::sqrt;
  if constexpr (KERNEL == Kernel::CONSTANT) {
    return q;
  } else if constexpr (KERNEL == Kernel::CONE) {
    return q * (T(3) - T(2) * sqrt(q));
  } else {
    return q * (T(2) - q);
  }
}

/** Calls f with the kernel as a std::integral_constant. The only switch over kernels. */
template <class F> decltype(auto) withKernel(Kernel kernel, F&& f) {
  switch (kernel) {
  case Kernel::CONSTANT:
    return f(std::integral_constant<Kernel, Kernel::CONSTANT>());
  case Kernel::CONE:
    return f(std::integral_constant<Kernel, Kernel::CONE>());
  case Kernel::EPANECHNIKOV:
    break;
  }
  return f(std::integral_constant<Kernel, Kernel::EPANECHNIKOV>());
}

} // namespace recurse
