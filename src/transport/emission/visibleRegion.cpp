/** @file
 * Hashed cells of the visible region.
 */
#include "transport/emission/visibleRegion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "recurse/core/sampling/sampler.h"

namespace recurse {

uint64_t VisibleRegion::Cells::key(int level, const Vec3f& position) {
  const double side = std::ldexp(1.0, level);
  uint64_t key = mixBits(static_cast<uint64_t>(level + 4096));
  for (int axis = 0; axis < 3; ++axis)
    key = hashCombine(key,
                      static_cast<uint64_t>(static_cast<int64_t>(std::floor(double(position[axis]) / side))));
  return key;
}

void VisibleRegion::add(const Vec3f& position, float size) { surfaces.add(position, size, 1); }

void VisibleRegion::addInMedium(const Vec3f& position, float size, float weight) {
  media.add(position, size, weight);
}

void VisibleRegion::Cells::add(const Vec3f& position, float size, float weight) {
  int level = 0;
  std::frexp(2 * size, &level); // the cell's side is at least 2·size
  if (std::find(levels.begin(), levels.end(), level) == levels.end()) levels.push_back(level);
  std::array<uint64_t, 8> keys;
  for (size_t corner = 0; corner < 8; ++corner) {
    Vec3f p = position;
    for (int axis = 0; axis < 3; ++axis) p[axis] += corner >> axis & 1 ? size : -size;
    keys[corner] = key(level, p);
  }
  std::sort(keys.begin(), keys.end());
  const auto end = std::unique(keys.begin(), keys.end());
  for (auto k = keys.begin(); k != end; ++k) weights[*k] += std::ldexp(weight, -2 * level);
}

float VisibleRegion::Cells::importance(const Vec3f& position) const {
  float sum = 0;
  for (const int level : levels)
    if (const auto found = weights.find(key(level, position)); found != weights.end()) sum += found->second;
  return sum;
}

} // namespace recurse
