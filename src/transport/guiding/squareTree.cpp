/** @file
 * Construction of quadtrees from weighted points; sampling and density.
 */
#include "transport/guiding/squareTree.h"

#include <algorithm>

namespace recurse {

namespace {

/** Index of the quarter of the unit square that contains a point, which changes to its frame. */
size_t descend(Vec2f& point) {
  const size_t x = point.x >= 0.5f, y = point.y >= 0.5f;
  point = 2.0f * point - Vec2f(x, y);
  return x + 2 * y;
}

/** Returns true with probability second / (first + second), decided by the uniform number u. Rescales u to be
 * uniform in [0, 1) again. */
bool choose(float first, float second, float& u) {
  const float bound = first / (first + second);
  const bool isSecond = u >= bound;
  u = isSecond ? (u - bound) / (1 - bound) : u / bound;
  u = std::min(u, ONE_MINUS_EPSILON);
  return isSecond;
}

} // namespace

struct SquareTree::Builder {
  std::vector<Node>& nodes;
  double total = 0;
  std::vector<double> mass{}; ///< weight of leaf `quarter` of node i: [4 i + quarter]

  /** Divides node `index`. The points are in the coordinates of that node. */
  void divide(uint32_t index, std::span<WeightedPoint> points, int depth) {
    const auto byY = std::stable_partition(points.begin(), points.end(),
                                           [](const WeightedPoint& p) { return p.point.y < 0.5f; });
    const auto byX = [](const WeightedPoint& p) { return p.point.x < 0.5f; };
    const auto low = std::stable_partition(points.begin(), byY, byX),
               high = std::stable_partition(byY, points.end(), byX);
    const std::array<decltype(byY), 5> ends{points.begin(), low, byY, high, points.end()};
    for (size_t quarter = 0; quarter < 4; ++quarter) {
      const std::span<WeightedPoint> inside(ends[quarter], ends[quarter + 1]);
      double sum = 0, squares = 0;
      for (const WeightedPoint& p : inside) {
        sum += double(p.weight);
        squares += square(double(p.weight));
      }
      if (depth + 1 >= MAX_DEPTH || !(sum > MAX_MASS * total) || square(sum) < MIN_EFFECTIVE * squares)
        continue;
      const auto child = static_cast<uint32_t>(nodes.size());
      nodes[index].child[quarter] = child;
      nodes.emplace_back();
      for (WeightedPoint& p : inside) descend(p.point);
      divide(child, inside, depth + 1);
      const Vec2f corner(quarter % 2, quarter / 2);
      for (WeightedPoint& p : inside) p.point = (p.point + corner) * 0.5f;
    }
  }

  /** Side length of the leaf that contains a point. */
  float leafSide(Vec2f point) const {
    float side = 0.5f;
    for (uint32_t node = 0;; side *= 0.5f) {
      const uint32_t child = nodes[node].child[descend(point)];
      if (child == 0) return side;
      node = child;
    }
  }

  /** Distributes the weight of a box of constant density to the leaves below a node by overlap. The box is in
   * the node's coordinates. */
  void spread(uint32_t node, const Vec2f& lower, const Vec2f& upper, double density) {
    for (uint32_t quarter = 0; quarter < 4; ++quarter) {
      const Vec2f corner = 0.5f * Vec2f(quarter % 2, quarter / 2);
      const Vec2f from = glm::max(lower, corner), to = glm::min(upper, corner + 0.5f);
      if (!(from.x < to.x && from.y < to.y)) continue;
      if (const uint32_t child = nodes[node].child[quarter])
        spread(child, 2.0f * (from - corner), 2.0f * (to - corner), density / 4);
      else
        mass[4 * node + quarter] += density * double(to.x - from.x) * double(to.y - from.y);
    }
  }

  /** Spreads the weight of each point over a box as large as its leaf, which smooths the density. */
  void spreadAll(std::span<const WeightedPoint> points) {
    mass.assign(4 * nodes.size(), 0);
    for (const WeightedPoint& p : points) {
      const float side = leafSide(p.point);
      const Vec2f lower = glm::clamp(p.point - 0.5f * side, Vec2f(0), Vec2f(1 - side));
      spread(0, lower, lower + side, double(p.weight) / square(double(side)));
    }
  }

  /** Weight below a node. Sets the fractions of its children. */
  double sumUp(uint32_t node) {
    std::array<double, 4> parts{};
    double sum = 0;
    for (uint32_t quarter = 0; quarter < 4; ++quarter) {
      const uint32_t child = nodes[node].child[quarter];
      parts[quarter] = child ? sumUp(child) : mass[4 * node + quarter];
      sum += parts[quarter];
    }
    if (sum > 0)
      for (size_t quarter = 0; quarter < 4; ++quarter)
        nodes[node].fraction[quarter] = static_cast<float>(parts[quarter] / sum);
    return sum;
  }
};

SquareTree::SquareTree(std::span<WeightedPoint> points) : nodes(1) {
  Builder builder{nodes};
  for (const WeightedPoint& p : points) builder.total += double(p.weight);
  if (!(builder.total > 0)) return;
  builder.divide(0, points, 0);
  builder.spreadAll(points);
  builder.sumUp(0);
}

float SquareTree::pdf(Vec2f point) const {
  float density = 1;
  for (uint32_t node = 0;;) {
    const size_t quarter = descend(point);
    density *= 4 * nodes[node].fraction[quarter];
    node = nodes[node].child[quarter];
    if (node == 0) return density;
  }
}

Vec2f SquareTree::sample(Vec2f u, float& density) const {
  Vec2f corner(0);
  float side = 1;
  density = 1;
  for (uint32_t node = 0;;) {
    const std::array<float, 4>& f = nodes[node].fraction;
    const size_t x = choose(f[0] + f[2], f[1] + f[3], u.x), y = choose(f[x], f[x + 2], u.y),
                 quarter = x + 2 * y;
    side *= 0.5f;
    corner += side * Vec2f(x, y);
    density *= 4 * f[quarter];
    node = nodes[node].child[quarter];
    if (node == 0) return corner + side * u;
  }
}

} // namespace recurse
