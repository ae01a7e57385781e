/** @file
 * Region that the camera sees, to which photons are guided.
 */
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

/** Region where the camera reads the photon map, as hashed cells of a few sizes. */
class VisibleRegion {
 public:
  /** Adds at least all points within `size` > 0 [scene units] of the position. */
  void add(const Vec3f& position, float size);
  bool contains(const Vec3f& position) const { return importance(position) > 0; }
  /** Visible-point density on surfaces [1/area]; 0 outside of the region. */
  float importance(const Vec3f& position) const { return surfaces.importance(position); }
  /** Adds a point in a medium with a weight. Its density is per area perpendicular to the camera rays. */
  void addInMedium(const Vec3f& position, float size, float weight);
  float importanceInMedium(const Vec3f& position) const { return media.importance(position); }
  bool empty() const { return surfaces.empty() && media.empty(); }

 private:
  class Cells {
   public:
    void add(const Vec3f& position, float size, float weight);
    float importance(const Vec3f& position) const;
    bool empty() const { return weights.empty(); }

   private:
    static uint64_t key(int level, const Vec3f& position);
    std::unordered_map<uint64_t, float> weights;
    std::vector<int> levels; ///< cells of side 2^level
  };
  Cells surfaces, media;
};

} // namespace recurse
