/** @file
 * Vectors and colours as the columns of records for NumPy.
 */
#pragma once

#include <array>

#include "recurse/model/scene/scene.h"

namespace recurse::python {

/** Three floats of a vector or a colour. */
template <class V> std::array<float, 3> floats(const V& v) { return {v[0], v[1], v[2]}; }

/** World-space position of a point, whose coordinates in the scene are relative to its origin. */
inline std::array<double, 3> worldPosition(const Scene& scene, const Vec3f& position) {
  std::array<double, 3> out{};
  for (int i = 0; i < 3; ++i) out[size_t(i)] = scene.origin()[i] + double(position[i]);
  return out;
}

} // namespace recurse::python
