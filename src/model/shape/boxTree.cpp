/** @file
 * Construction of box trees: median splits along the widest axis of the centres.
 */
#include "recurse/model/shape/boxTree.h"

#include <numeric>

namespace recurse {

BoxTree::BoxTree(const std::vector<Bounds3d>& boxes) : order(boxes.size()) {
  if (boxes.empty()) return;
  std::iota(order.begin(), order.end(), 0u);
  nodes.reserve(boxes.size() + 1);
  nodes.emplace_back();
  build(boxes, 0, 0, static_cast<uint32_t>(boxes.size()));
}

void BoxTree::build(const std::vector<Bounds3d>& boxes, uint32_t node, uint32_t begin, uint32_t end) {
  Bounds3d all, centers;
  for (uint32_t i = begin; i < end; ++i) {
    all.add(boxes[order[i]]);
    centers.add(boxes[order[i]].center());
  }
  const Vec3d slack = 1e-12 * (glm::abs(all.lower) + glm::abs(all.upper) + glm::length(all.diagonal()));
  nodes[node].lower = all.lower - slack;
  nodes[node].upper = all.upper + slack;
  if (end - begin <= LEAF_SIZE) {
    nodes[node].first = begin;
    nodes[node].count = end - begin;
    return;
  }
  const int axis = widestAxis(centers.diagonal());
  const uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(
      order.begin() + begin, order.begin() + middle, order.begin() + end, [&](uint32_t a, uint32_t b) {
        return boxes[a].lower[axis] + boxes[a].upper[axis] < boxes[b].lower[axis] + boxes[b].upper[axis];
      });
  const auto children = static_cast<uint32_t>(nodes.size());
  nodes[node].first = children;
  nodes.resize(nodes.size() + 2);
  build(boxes, children, begin, middle);
  build(boxes, children + 1, middle, end);
}

} // namespace recurse
