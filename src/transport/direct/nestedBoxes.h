/** @file
 * Distribution of points as nested boxes: leaves with about equal numbers of points, and boxes around leaves.
 */
#pragma once

#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

struct WeightedPosition {
  Vec3f position;
  float weight;
};

class NestedBoxes {
 public:
  struct Box {
    Bounds3f bounds;
    float chance;   ///< probability of this box
    bool leaf;      ///< false: encloses leaves, for points between them
    float upToHere; ///< cumulative probability of this box and all before it
  };

  /** No boxes. */
  NestedBoxes() = default;
  /** Builds boxes whose probabilities follow the weights. `levels`: there are at most 2^levels leaves;
   * `margin`: margin around each box [scene units]. */
  NestedBoxes(std::vector<WeightedPosition> positions, int levels, float margin);

  bool empty() const { return boxes.empty(); }
  size_t size() const { return boxes.size(); }
  std::vector<Box>::const_iterator begin() const { return boxes.begin(); }
  std::vector<Box>::const_iterator end() const { return boxes.end(); }
  /** Samples a box by `pick` in [0, 1), and replaces `pick` by its rescaled remainder in [0, 1]. */
  const Box& choose(float& pick) const;

 private:
  void split(std::vector<WeightedPosition>::iterator first, std::vector<WeightedPosition>::iterator last,
             int levels, float margin);

  std::vector<Box> boxes;
};

} // namespace recurse
