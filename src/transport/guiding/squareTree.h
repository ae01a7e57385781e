/** @file
 * Densities over the unit square as adaptive quadtrees (Müller, Gross, Novák 2017, "Practical Path Guiding
 * for Efficient Light-Transport Simulation", section 3).
 */
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

struct WeightedPoint {
  Vec2f point{0}; ///< in [0, 1)²
  float weight = 0;
};

/** A piecewise constant density over the unit square. Built once, then read by any number of threads. */
class SquareTree {
 public:
  /** The uniform density. */
  SquareTree() : nodes(1) {}

  /** Density of the weighted points, each spread over a box as large as its leaf; uniform without weight. A
   * quarter is divided while it has more than MAX_MASS of the total weight and at least MIN_EFFECTIVE
   * effective points, down to MAX_DEPTH levels. Changes the order of `points`. */
  explicit SquareTree(std::span<WeightedPoint> points);

  /** Density at a point [1/area]; 1 everywhere for the uniform density. */
  float pdf(Vec2f point) const;
  /** Samples a point from the density by a monotone warp of each of the two uniform numbers in turn. Stores
   * its density in `density`. */
  Vec2f sample(Vec2f u, float& density) const;

  size_t nodeCount() const { return nodes.size(); }

  static constexpr double MAX_MASS = 0.01;
  static constexpr double MIN_EFFECTIVE = 16;
  static constexpr int MAX_DEPTH = 10;

 private:
  /** Inner node. Children in the order (x, y) = (0, 0), (1, 0), (0, 1), (1, 1). */
  struct Node {
    std::array<float, 4> fraction{0.25f, 0.25f, 0.25f, 0.25f}; ///< each quarter's fraction of the probability
    std::array<uint32_t, 4> child{};                           ///< indices of nodes; 0: a leaf
  };
  struct Builder;

  std::vector<Node> nodes; ///< [0] is the root
};

} // namespace recurse
