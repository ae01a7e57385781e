/** @file
 * Values on a regular grid that fills the unit cube, with linear interpolation between the cells' centres;
 * outside they are zero.
 */
#pragma once

#include <vector>

#include "recurse/core/math/rgb.h"
#include "recurse/model/medium/medium.h"

namespace recurse {

template <class T> class SampledGrid {
 public:
  SampledGrid() = default;
  /** x runs fastest, z slowest. */
  SampledGrid(const glm::ivec3& size, std::vector<T> values) : count(size), values(std::move(values)) {}

  const glm::ivec3& size() const { return count; }
  bool empty() const { return values.empty(); }
  T value(const glm::ivec3& i) const {
    if (i.x < 0 || i.y < 0 || i.z < 0 || i.x >= count.x || i.y >= count.y || i.z >= count.z) return T(0);
    return values[(size_t(i.z) * size_t(count.y) + size_t(i.y)) * size_t(count.x) + size_t(i.x)];
  }
  /** Interpolated value at a point of the unit cube. */
  T at(const Vec3f& p) const {
    const Vec3f q = p * Vec3f(count) - 0.5f, floor = glm::floor(q), part = q - floor;
    // The test is false for NaN as well, so that the coordinates fit an integer.
    if (!(floor.x >= -1 && floor.y >= -1 && floor.z >= -1 && floor.x < float(count.x) &&
          floor.y < float(count.y) && floor.z < float(count.z)))
      return T(0);
    const glm::ivec3 i(floor);
    T sum(0);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::ivec3 d(corner & 1, corner >> 1 & 1, corner >> 2);
      const float weight =
          (d.x ? part.x : 1 - part.x) * (d.y ? part.y : 1 - part.y) * (d.z ? part.z : 1 - part.z);
      sum += value(i + d) * weight;
    }
    return sum;
  }

 private:
  glm::ivec3 count{0};
  std::vector<T> values;
};

/** Majorants of an interpolated field by cells. `largest(i)` is the bound of the field at sample i, which
 * may be outside of the grid by one. */
template <class Largest> MajorantGrid majorantsOf(const glm::ivec3& samples, const Largest& largest) {
  constexpr int MAX_CELLS = 64; // cells along an axis; with more, traversal costs about as much as it saves
  const glm::ivec3 cells = glm::min(samples, glm::ivec3(MAX_CELLS));
  std::vector<float> bounds;
  for (int z = 0; z < cells.z; ++z)
    for (int y = 0; y < cells.y; ++y)
      for (int x = 0; x < cells.x; ++x) {
        const glm::ivec3 cell(x, y, z);
        // Samples whose filter support reaches the cell, and one more for points rounded out of it.
        const glm::ivec3 first = cell * samples / cells - 1,
                         last = ((cell + 1) * samples + cells - 1) / cells + 1;
        float bound = 0;
        for (int k = first.z; k < last.z; ++k)
          for (int j = first.y; j < last.y; ++j)
            for (int i = first.x; i < last.x; ++i) bound = std::max(bound, largest(glm::ivec3(i, j, k)));
        bounds.push_back(bound);
      }
  return {cells, std::move(bounds)};
}

} // namespace recurse
