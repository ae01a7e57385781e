/** @file
 * Splitting of points into nested boxes.
 */
#include "transport/direct/nestedBoxes.h"

#include <algorithm>

namespace recurse {

NestedBoxes::NestedBoxes(std::vector<WeightedPosition> positions, int levels, float margin) {
  split(positions.begin(), positions.end(), levels, margin);
  float all = 0;
  for (const Box& box : boxes) all += box.chance;
  float sum = 0;
  for (Box& box : boxes) {
    box.chance /= all;
    box.upToHere = sum += box.chance;
  }
}

void NestedBoxes::split(std::vector<WeightedPosition>::iterator first,
                        std::vector<WeightedPosition>::iterator last, int levels, float margin) {
  constexpr std::ptrdiff_t MIN_POSITIONS = 32;
  // Enclosing boxes sample the space between leaves hundreds of times as often as without them.
  constexpr float INNER = 0.1f, GROWTH = 0.05f;
  Bounds3f bounds;
  float weight = 0;
  for (auto i = first; i != last; ++i) {
    bounds.add(i->position);
    weight += i->weight;
  }
  if (levels == 0 || last - first < 2 * MIN_POSITIONS) {
    bounds.lower -= margin;
    bounds.upper += margin;
    boxes.push_back({bounds, weight, true, 0});
    return;
  }
  if (levels % 2 == 0) {
    const Vec3f more = bounds.diagonal() * GROWTH + margin;
    boxes.push_back({{bounds.lower - more, bounds.upper + more}, INNER * weight, false, 0});
  }
  const int axis = widestAxis(bounds.diagonal());
  const auto middle = first + (last - first) / 2;
  std::nth_element(first, middle, last, [&](const WeightedPosition& a, const WeightedPosition& b) {
    return a.position[axis] < b.position[axis];
  });
  split(first, middle, levels - 1, margin);
  split(middle, last, levels - 1, margin);
}

const NestedBoxes::Box& NestedBoxes::choose(float& pick) const {
  const auto box = std::upper_bound(boxes.begin(), boxes.end() - 1, pick,
                                    [](float value, const Box& b) { return value < b.upToHere; });
  pick = std::clamp((pick - (box->upToHere - box->chance)) / box->chance, 0.0f, 1.0f);
  return *box;
}

} // namespace recurse
