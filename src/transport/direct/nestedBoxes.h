/** @file
 * A distribution of places as boxes of about as many each, and larger boxes around those.
 */
#pragma once

#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

struct WeightedPlace {
  Vec3f position;
  float weight;
};

class NestedBoxes {
 public:
  struct Box {
    Bounds3f bounds;
    float chance;   ///< of this box
    bool leaf;      ///< others enclose leaves, for what lies in between
    float upToHere; ///< chances of this box and those before it
  };

  /** None. */
  NestedBoxes() = default;
  /** Chances follow the weights. `levels`: 2^levels leaves at the most; `margin`: around each [scene units].
   */
  NestedBoxes(std::vector<WeightedPlace> places, int levels, float margin);

  bool empty() const { return boxes.empty(); }
  size_t size() const { return boxes.size(); }
  std::vector<Box>::const_iterator begin() const { return boxes.begin(); }
  std::vector<Box>::const_iterator end() const { return boxes.end(); }
  /** By a number in [0, 1), of which what is left over, in [0, 1], takes its place. */
  const Box& choose(float& pick) const;

 private:
  void split(std::vector<WeightedPlace>::iterator first, std::vector<WeightedPlace>::iterator last,
             int levels, float margin);

  std::vector<Box> boxes;
};

} // namespace recurse
