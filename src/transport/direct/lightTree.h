/** @file
 * Binary tree of lights by position, with probabilities by power over squared distance (Conty Estevez and
 * Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting").
 */
#pragma once

#include <span>
#include <vector>

#include "recurse/model/scene/scene.h"

namespace recurse {

/** Leaves are the lights with power, in an order by position. The first levels end at clusters, whose
 * probabilities others may learn. */
struct LightTree {
  /** Node of the leaves [first, end) in `order`. Its left child follows it in `nodes`. The right child's
   * index is computed, since the halves differ by at most one light. */
  struct Node {
    Vec3f center{0};
    float radius2 = 0; ///< squared radius of the sphere around its emission positions
    float power = 0;   ///< fraction of all power
  };
  struct Cluster {
    uint32_t node, first, end;
  };
  std::vector<uint32_t> order, rank; ///< indices of lights by leaf, and the inverse
  std::vector<Node> nodes;
  std::vector<Cluster> clusters;   ///< nodes at which the first levels end, from left to right
  std::vector<uint32_t> clusterOf; ///< index of the cluster by leaf

  /** Builds the tree; empty if fewer than two lights have power. */
  void build(const LightTable& lights);
  bool empty() const { return order.empty(); }
  Cluster root() const { return {0, 0, static_cast<uint32_t>(order.size())}; }

  struct Chosen {
    uint32_t leaf;
    double probability;
  };
  /** Chooses a leaf below a node by the number `u` in [0,1), which is replaced by a new uniform number. */
  Chosen choose(const Cluster& below, const Vec3f& position, double& u) const;
  /** Probability that choose() chooses a leaf from its cluster. */
  double probability(const Vec3f& position, uint32_t leaf) const;

  /** Descent from a node to a leaf. */
  class Descent {
   public:
    /** `near2`: squared distance below which lights are not distinguished by distance. */
    Descent(const LightTree& tree, const Vec3f& position, float near2, const Cluster& from)
        : tree(tree), position(position), near2(near2), at(from) {}

    bool atLeaf() const { return at.end - at.first == 1; }
    const Cluster& where() const { return at; }
    /** First leaf of the right child. */
    uint32_t middle() const { return at.first + (at.end - at.first) / 2; }
    /** Probability of the left child. */
    double left() const;
    void go(bool toTheLeft) {
      if (toTheLeft)
        at = {at.node + 1, at.first, middle()};
      else
        at = {right(), middle(), at.end};
    }

   private:
    uint32_t right() const { return at.node + 2 * (middle() - at.first); }
    const LightTree& tree;
    const Vec3f position;
    const float near2;
    Cluster at;
  };

 private:
  void buildNode(std::span<const Bounds3f> boxes, const LightTable& lights, size_t first, size_t end,
                 int depth);
};

} // namespace recurse
