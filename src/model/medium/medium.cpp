/** @file
 * Traversal of a grid's cells by a ray (Amanatides and Woo 1987, "A Fast Voxel Traversal
 * Algorithm").
 */
#include "recurse/model/medium/medium.h"

#include <algorithm>

namespace recurse {

MajorantSegments::MajorantSegments(const MajorantGrid& grid, const Rgb& extinction, const Vec3f& origin,
                                   const Vec3f& direction, float end)
    : whole{0, 0, extinction}, grid(&grid) {
  float enter = 0, leave = end;
  for (int a = 0; a < 3; ++a) {
    if (direction[a] == 0) {
      if (origin[a] < 0 || origin[a] > 1) return;
      continue;
    }
    float low = -origin[a] / direction[a], high = (1 - origin[a]) / direction[a];
    if (low > high) std::swap(low, high);
    enter = std::max(enter, low);
    leave = std::min(leave, high);
  }
  if (!(enter < leave)) return;
  t = enter;
  this->end = leave;
  const Vec3f at = origin + direction * enter;
  for (int a = 0; a < 3; ++a) {
    const auto count = static_cast<float>(grid.size()[a]);
    cell[a] = std::clamp(static_cast<int>(at[a] * count), 0, grid.size()[a] - 1);
    if (direction[a] == 0) {
      nextT[a] = INFINITE;
      continue;
    }
    step[a] = direction[a] > 0 ? 1 : -1;
    deltaT[a] = 1 / (std::abs(direction[a]) * count);
    const float border = static_cast<float>(cell[a] + (step[a] > 0)) / count;
    nextT[a] = (border - origin[a]) / direction[a];
  }
}

bool MajorantSegments::next(MajorantSegment& segment) {
  if (one) {
    one = false;
    segment = whole;
    return whole.end > 0;
  }
  while (t < end) {
    const int a = nextT.x < nextT.y ? (nextT.x < nextT.z ? 0 : 2) : (nextT.y < nextT.z ? 1 : 2);
    segment.begin = t;
    segment.end = t = std::max(t, std::min(nextT[a], end));
    const float bound = grid->at(cell);
    if (nextT[a] >= end) t = end;
    cell[a] += step[a];
    nextT[a] += deltaT[a];
    if (cell[a] < 0 || cell[a] >= grid->size()[a]) {
      segment.end = std::max(segment.end, end);
      t = end;
    }
    if (!(bound > 0) || !(segment.begin < segment.end)) continue;
    segment.majorant = whole.majorant * bound;
    return true;
  }
  return false;
}

} // namespace recurse
