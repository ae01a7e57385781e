/** @file
 * Bounding volume hierarchy within one shape or texture, over its operands, balls or triangles.
 */
#pragma once

#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

/** Tree in double precision; also finds boxes that a line misses only by rounding. */
class BoxTree {
 public:
  BoxTree() = default;
  explicit BoxTree(const std::vector<Bounds3d>& boxes);

  /** Calls visit(index) in any order for each box that the line origin + t·direction intersects between tMin
   * and tMax, and possibly for boxes nearby. */
  template <class Visit>
  void visit(const Vec3d& origin, const Vec3d& direction, double tMin, double tMax,
             const Visit& visit) const {
    if (nodes.empty()) return;
    const Vec3d inverse = 1.0 / direction;
    uint32_t stack[STACK_SIZE];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& n = nodes[stack[--top]];
      if (!n.intersects(origin, inverse, tMin, tMax)) continue;
      if (n.count > 0) {
        for (uint32_t i = 0; i < n.count; ++i) visit(order[n.first + i]);
      } else {
        stack[top++] = n.first;
        stack[top++] = n.first + 1;
      }
    }
  }

 private:
  /** Capacity of the stack. A split halves the number of boxes: at most 32 levels, which leave one entry
   * each, and one more at the last. */
  static constexpr int STACK_SIZE = 64;
  static constexpr uint32_t LEAF_SIZE = 2;
  struct Node {
    Vec3d lower, upper;
    uint32_t first = 0; ///< child, or index into `order`
    uint32_t count = 0; ///< 0: two children

    bool intersects(const Vec3d& origin, const Vec3d& inverse, double tMin, double tMax) const {
      for (int i = 0; i < 3; ++i) {
        if (std::isinf(inverse[i])) {
          if (origin[i] < lower[i] || origin[i] > upper[i]) return false;
          continue;
        }
        const double a = (lower[i] - origin[i]) * inverse[i], b = (upper[i] - origin[i]) * inverse[i];
        tMin = std::max(tMin, std::min(a, b));
        tMax = std::min(tMax, std::max(a, b));
      }
      return tMin <= tMax;
    }
  };
  void build(const std::vector<Bounds3d>& boxes, uint32_t node, uint32_t begin, uint32_t end);

  std::vector<Node> nodes;
  std::vector<uint32_t> order;
};

} // namespace recurse
