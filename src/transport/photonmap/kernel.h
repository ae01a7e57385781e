/** @file
 * Kernels of density estimation: how much a photon counts by its distance from the point of interest.
 *
 * Each kernel K(d) lives on a disc of radius r and is normalised there: ∫ K(d) 2πd dd = 1 over [0, r]. So a
 * uniform irradiance field is estimated without bias wherever the disc lies within the surface. Kernels are
 * given by their shape π r² K as a function of q = d²/r², because d² and r² are what a photon map knows.
 */
#pragma once

#include <cmath>
#include <optional>
#include <string_view>
#include <type_traits>

#include "recurse/core/math/vector.h"

namespace recurse {

enum class Kernel {
  CONSTANT,    ///< K = 1 / (π r²): least noise for a given number of photons, sharp borders
  CONE,        ///< K = 3 (1 − d/r) / (π r²): Jensen's filter with k = 1
  EPANECHNIKOV ///< K = 2 (1 − d²/r²) / (π r²): least mean squared error (Silverman 1986, section 3.3.2)
};

constexpr Kernel ALL_KERNELS[] = {Kernel::CONSTANT, Kernel::CONE, Kernel::EPANECHNIKOV};

/**
 * π r² K at q = d²/r², for 0 <= q <= 1 (negative or undefined beyond). T is float, double or Float8. The
 * kernel is a template argument so that an inner loop pays nothing for the choice.
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

/** The kernel's part on a narrow sector that ends at q = d²/r²: ∫ from 0 to q of π r² K dq. */
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

/** Calls f with the kernel as a std::integral_constant: the one switch over kernels. */
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

/** K(d) itself [1/area] for distance² <= radius²; 0 beyond. */
inline float kernelValue(Kernel kernel, float distance2, float radius2) {
  if (!(distance2 <= radius2)) return 0;
  const float shape = withKernel(kernel, [&](auto k) { return kernelShape<k.value>(distance2 / radius2); });
  return shape * INV_PI / radius2;
}

constexpr const char* kernelName(Kernel kernel) {
  switch (kernel) {
  case Kernel::CONSTANT:
    return "constant";
  case Kernel::CONE:
    return "cone";
  case Kernel::EPANECHNIKOV:
    break;
  }
  return "epanechnikov";
}

/** The kernel of that name; nothing for an unknown one. */
constexpr std::optional<Kernel> parseKernel(std::string_view name) {
  for (const Kernel kernel : ALL_KERNELS)
    if (name == kernelName(kernel)) return kernel;
  return std::nullopt;
}

} // namespace recurse
