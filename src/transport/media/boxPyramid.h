/** @file
 * Complete binary tree of boxes over items, which it sorts. Independent of the number of threads.
 */
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "recurse/core/math/ray.h"
#include "recurse/core/threads/parallel.h"

namespace recurse {

/** Side lengths of a box. A flat box, such as the cross-section of a beam, counts as a tenth as thick as it
 * is wide. */
inline Vec3f thickSides(const Bounds3f& box) {
  constexpr float FLAT = 0.1f;
  const Vec3f sides = box.diagonal();
  return glm::max(sides, Vec3f(FLAT * sides[widestAxis(sides)]));
}

class BoxPyramid {
 public:
  /** Sorts the items so that each node halves them by number along the widest axis of position(item). */
  template <class Item, class Position> void sort(std::vector<Item>& items, const Position& position) {
    count = items.size();
    levels = 0;
    while (levels < MAX_LEVELS && count >> levels > LEAF) ++levels;
    for (uint32_t level = 0; level < levels; ++level)
      parallelFor(size_t(1) << level, [&](size_t i) {
        const auto at = [&](uint32_t l, size_t index) {
          return items.begin() + static_cast<std::ptrdiff_t>(firstOf(l, index));
        };
        const auto first = at(level, i), end = at(level, i + 1);
        Bounds3f box;
        for (auto p = first; p != end; ++p) box.add(position(*p));
        const int axis = widestAxis(box.diagonal());
        std::nth_element(first, at(level + 1, 2 * i + 1), end,
                         [&](const Item& a, const Item& b) { return position(a)[axis] < position(b)[axis]; });
      });
  }

  /** Calls visit(first, end) for the item ranges of nodes with 36 to 72 items, or for all items if they are
   * fewer, in parallel. */
  template <class Visit> void forParts(const Visit& visit) const {
    const uint32_t level = levels - std::min(levels, LEVELS_OF_PART);
    parallelFor(size_t(1) << level, [&](size_t i) { visit(firstOf(level, i), firstOf(level, i + 1)); });
  }

  /** Computes the boxes: add(box, i) extends a box by item i. */
  template <class Add> void enclose(const Add& add) {
    boxes.assign((size_t(2) << levels) - 1, Bounds3f());
    const size_t leaves = (size_t(1) << levels) - 1;
    parallelFor(size_t(1) << levels, [&](size_t i) {
      for (size_t k = firstOf(levels, i); k < firstOf(levels, i + 1); ++k) add(boxes[leaves + i], k);
    });
    for (size_t i = leaves; i-- > 0;) {
      boxes[i].add(boxes[2 * i + 1]);
      boxes[i].add(boxes[2 * i + 2]);
    }
  }

  /** Calls visit(i) for each item whose leaf the ray intersects before `end`. */
  template <class Visit> void visitAlong(const Ray& ray, float end, const Visit& visit) const {
    if (count == 0) return;
    struct Node {
      uint32_t level, index;
    };
    Node stack[MAX_LEVELS + 1];
    int top = 0;
    stack[top++] = {0, 0};
    const Vec3f inverse = 1.0f / ray.direction;
    while (top > 0) {
      const Node node = stack[--top];
      if (!intersects(boxes[(size_t(1) << node.level) - 1 + node.index], ray.origin, inverse, end)) continue;
      if (node.level < levels) {
        stack[top++] = {node.level + 1, 2 * node.index};
        stack[top++] = {node.level + 1, 2 * node.index + 1};
        continue;
      }
      for (size_t i = firstOf(node.level, node.index); i < firstOf(node.level, node.index + 1); ++i) visit(i);
    }
  }

  size_t memoryBytes() const { return boxes.capacity() * sizeof(Bounds3f); }

 private:
  static constexpr uint32_t MAX_LEVELS = 28, LEVELS_OF_PART = 3;
  static constexpr size_t LEAF = 8;

  /** Index of the first item of a node; the items end where the next node begins. */
  size_t firstOf(uint32_t level, size_t index) const { return count * index >> level; }
  static bool intersects(const Bounds3f& box, const Vec3f& origin, const Vec3f& inverse, float end) {
    // For a ray in the plane of a side, 0 · infinity is NaN. In this order, min and max ignore it at the
    // lower side. At the upper side the ray misses, which is harmless: boxes are wider than their contents.
    float enter = 0, leave = end;
    for (int a = 0; a < 3; ++a) {
      const float t0 = (box.lower[a] - origin[a]) * inverse[a], t1 = (box.upper[a] - origin[a]) * inverse[a];
      enter = std::max(enter, std::min(t0, t1));
      leave = std::min(leave, std::max(t0, t1));
    }
    return enter <= leave;
  }

  uint32_t levels = 0; ///< level of the leaves
  size_t count = 0;
  std::vector<Bounds3f> boxes; ///< level by level
};

} // namespace recurse
