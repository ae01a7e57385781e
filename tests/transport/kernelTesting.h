/** @file
 * All kernels of density estimates, with names and values.
 */
#pragma once

#include "transport/photonmap/kernel.h"

namespace recurse::testing {

constexpr Kernel ALL_KERNELS[] = {Kernel::CONSTANT, Kernel::CONE, Kernel::EPANECHNIKOV};

/** Kernel K(d) [1/area] for distance² <= radius²; 0 beyond. */
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

} // namespace recurse::testing
