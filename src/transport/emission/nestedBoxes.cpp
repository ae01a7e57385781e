/** @file
 * Splitting of points into nested boxes.
 */
#include "transport/emission/nestedBoxes.h"

#include <algorithm>
#include <span>

namespace recurse {

namespace {

void split(std::span<WeightedPosition> positions, int levels, float margin, std::vector<NestedBox>& boxes) {
  constexpr size_t MIN_POSITIONS = 32;
  // Enclosing boxes sample the space between leaves hundreds of times as often as without them.
  constexpr float INNER = 0.1f, GROWTH = 0.05f;
  Bounds3f bounds;
  float weight = 0;
  for (const WeightedPosition& p : positions) {
    bounds.add(p.position);
    weight += p.weight;
  }
  const float more = GROWTH * glm::length(bounds.diagonal()) + margin; // a pane is flat
  if (levels == 0 || positions.size() < 2 * MIN_POSITIONS) {
    bounds.lower -= more;
    bounds.upper += more;
    boxes.push_back({bounds, weight});
    return;
  }
  if (levels % 2 == 0) {
    boxes.push_back({{bounds.lower - more, bounds.upper + more}, INNER * weight});
  }
  const int axis = widestAxis(bounds.diagonal());
  const size_t middle = positions.size() / 2;
  std::nth_element(positions.begin(), positions.begin() + static_cast<std::ptrdiff_t>(middle),
                   positions.end(), [&](const WeightedPosition& a, const WeightedPosition& b) {
                     return a.position[axis] < b.position[axis];
                   });
  split(positions.first(middle), levels - 1, margin, boxes);
  split(positions.subspan(middle), levels - 1, margin, boxes);
}

} // namespace

std::vector<NestedBox> nestedBoxes(std::vector<WeightedPosition> positions, int levels, float margin) {
  std::vector<NestedBox> boxes;
  if (positions.empty()) return boxes;
  split(positions, levels, margin, boxes);
  float sum = 0;
  for (const NestedBox& box : boxes) sum += box.chance;
  for (NestedBox& box : boxes) box.chance /= sum;
  return boxes;
}

} // namespace recurse
