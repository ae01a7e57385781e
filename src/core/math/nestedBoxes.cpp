/** @file
 * Construction of nested boxes by median splits.
 */
#include "recurse/core/math/nestedBoxes.h"

#include <algorithm>
#include <span>

namespace recurse {

namespace {

struct Splitter {
  float margin, inner;
  std::vector<NestedBox> boxes;

  void split(std::span<WeightedPosition> positions, int levels) {
    constexpr size_t MIN_POSITIONS = 32;
    constexpr float GROWTH = 0.05f;
    Bounds3f bounds;
    float weight = 0;
    for (const WeightedPosition& p : positions) {
      bounds.add(p.position);
      weight += p.weight;
    }
    const float more = GROWTH * glm::length(bounds.diagonal()) + margin;
    const auto add = [&](float chance) {
      boxes.push_back({{bounds.lower - more, bounds.upper + more}, chance});
    };
    if (levels == 0 || positions.size() < 2 * MIN_POSITIONS) return add(weight);
    if (inner > 0 && levels % 2 == 0) add(inner * weight);
    const int axis = widestAxis(bounds.diagonal());
    const size_t middle = positions.size() / 2;
    std::nth_element(positions.begin(), positions.begin() + static_cast<std::ptrdiff_t>(middle),
                     positions.end(), [&](const WeightedPosition& a, const WeightedPosition& b) {
                       return a.position[axis] < b.position[axis];
                     });
    split(positions.first(middle), levels - 1);
    split(positions.subspan(middle), levels - 1);
  }
};

} // namespace

std::vector<NestedBox> nestedBoxes(std::vector<WeightedPosition> positions, int levels, float margin,
                                   float inner) {
  Splitter splitter{margin, inner, {}};
  if (!positions.empty()) splitter.split(positions, levels);
  float sum = 0;
  for (const NestedBox& box : splitter.boxes) sum += box.chance;
  for (NestedBox& box : splitter.boxes) box.chance /= sum;
  return std::move(splitter.boxes);
}

} // namespace recurse
