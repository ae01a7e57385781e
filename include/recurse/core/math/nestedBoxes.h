/** @file
 * Boxes around positions with about equal numbers in each.
 */
#pragma once

#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

struct WeightedPosition {
  Vec3f position{0};
  float weight = 0;
};

struct NestedBox {
  Bounds3f bounds;
  float chance = 0; ///< fraction of the weight; sums to 1 over all boxes
};

/** Leaves with about equal numbers of positions, at most 2^levels, and boxes around several leaves, which
 * have `inner` times the chance of their leaves; none with `inner` 0. Empty without positions. `margin`:
 * margin around each box besides a twentieth of its diagonal [scene units]. */
std::vector<NestedBox> nestedBoxes(std::vector<WeightedPosition> positions, int levels, float margin,
                                   float inner);

} // namespace recurse
