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

struct NestedBox {
  Bounds3f bounds;
  float chance; ///< probability of this box
};

/** Boxes around positions, with probabilities that follow the weights; empty without positions. `levels`:
 * there are at most 2^levels leaves; `margin`: margin around each box [scene units]. */
std::vector<NestedBox> nestedBoxes(std::vector<WeightedPosition> positions, int levels, float margin);

} // namespace recurse
