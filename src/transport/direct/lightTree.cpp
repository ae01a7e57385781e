/** @file
 * Construction and descent of the light tree.
 */
#include "transport/direct/lightTree.h"

#include <algorithm>
#include <cmath>

namespace recurse {

namespace {

/** Number of levels above the clusters. */
constexpr int TABLE_DEPTH = 6;

} // namespace

double LightTree::Descent::left() const {
  const Node &whole = tree.nodes[at.node], &l = tree.nodes[at.node + 1], &r = tree.nodes[right()];
  // Bounds the distance from below: next to a light, or in its box, its sibling keeps some probability.
  const float least = std::max(whole.radius2 / 16, near2);
  const auto distance2 = [&](const Node& n) {
    return double(std::max(lengthSquared(n.center - position), std::max(n.radius2, least)));
  };
  double a = double(l.power), b = double(r.power);
  if (least > 0) {
    a *= distance2(r);
    b *= distance2(l);
  }
  return a / (a + b);
}

LightTree::Chosen LightTree::choose(const Cluster& below, const Vec3f& position, double& u) const {
  Descent way(*this, position, 0, below);
  double all = 1;
  while (!way.atLeaf()) {
    const double left = way.left();
    const bool toTheLeft = u < left;
    const double branch = toTheLeft ? left : 1 - left;
    u = (toTheLeft ? u : u - left) / branch;
    all *= branch;
    way.go(toTheLeft);
  }
  return {way.where().first, all};
}

double LightTree::probability(const Vec3f& position, uint32_t leaf) const {
  Descent way(*this, position, 0, clusters[clusterOf[leaf]]);
  double all = 1;
  while (!way.atLeaf()) {
    const double left = way.left();
    const bool toTheLeft = leaf < way.middle();
    all *= toTheLeft ? left : 1 - left;
    way.go(toTheLeft);
  }
  return all;
}

void LightTree::build(const LightTable& lights) {
  *this = {};
  // Only emission positions of a light are needed. A box that is too small costs only noise.
  constexpr int STARTS = 4;
  std::vector<Bounds3f> boxes(lights.size());
  for (size_t i = 0; i < lights.size(); ++i) {
    if (!(lights.probability(i) > 0)) continue; // no photon starts here
    order.push_back(static_cast<uint32_t>(i));
    for (int k = 0; k < STARTS; ++k) {
      const float a = (static_cast<float>(k) + 0.5f) / STARTS, b = std::fmod(a + 0.5f, 1.0f);
      if (const auto e = lights[i].sampleLe({a, {a, k % 2 ? 0.25f : 0.75f}, {b, a}, a}))
        boxes[i].add(e->origin);
    }
    if (boxes[i].empty()) boxes[i].add(Vec3f(0));
  }
  if (order.size() < 2) {
    order.clear();
    return;
  }
  nodes.reserve(2 * order.size());
  buildNode(boxes, lights, 0, order.size(), 0);
  for (uint32_t c = 0; c < clusters.size(); ++c)
    for (uint32_t i = clusters[c].first; i < clusters[c].end; ++i) clusterOf.push_back(c);
  rank.assign(lights.size(), 0);
  for (size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<uint32_t>(i);
}

void LightTree::buildNode(std::span<const Bounds3f> boxes, const LightTable& lights, size_t first, size_t end,
                          int depth) {
  Bounds3f box;
  double power = 0;
  for (size_t i = first; i < end; ++i) {
    box.add(boxes[order[i]]);
    power += double(lights.probability(order[i]));
  }
  if (depth == TABLE_DEPTH || (depth < TABLE_DEPTH && end - first == 1))
    clusters.push_back(
        {static_cast<uint32_t>(nodes.size()), static_cast<uint32_t>(first), static_cast<uint32_t>(end)});
  nodes.push_back({box.center(), lengthSquared(box.diagonal() / 2.0f), static_cast<float>(power)});
  if (end - first == 1) return;
  const int axis = widestAxis(box.diagonal());
  const auto doubledCenter = [&](uint32_t light) {
    return boxes[light].lower[axis] + boxes[light].upper[axis];
  };
  const size_t middle = first + (end - first) / 2;
  const auto at = [&](size_t i) { return order.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(first), at(middle), at(end), [&](uint32_t a, uint32_t b) {
    return doubledCenter(a) != doubledCenter(b) ? doubledCenter(a) < doubledCenter(b) : a < b;
  });
  buildNode(boxes, lights, first, middle, depth + 1);
  buildNode(boxes, lights, middle, end, depth + 1);
}

} // namespace recurse
