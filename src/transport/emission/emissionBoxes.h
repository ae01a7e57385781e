/** @file
 * Boxes to which lights emit: around vertices of camera paths, and around exits, where light of infinite
 * lights enters the scene.
 */
#pragma once

#include <array>
#include <vector>

#include "recurse/core/math/float8.h"
#include "recurse/transport/integrator/integrator.h"

namespace recurse {

/** Eight boxes, one in each SIMD lane, and the densities of rays that are sampled to hit them. */
class BoxBlock {
 public:
  /** No boxes. */
  BoxBlock() = default;
  void set(size_t lane, const Bounds3f& bounds);
  Bounds3f bounds(size_t lane) const;
  /** Bounding sphere of a box [scene units]. */
  Vec3f center(size_t lane) const { return bounds(lane).center(); }
  float radius(size_t lane) const { return glm::length(bounds(lane).diagonal()) / 2; }
  /** Emitted ray whose densities are asked for. `lightDensity`: density by the light's own sampling. */
  struct Line {
    Line(const Light& light, const LeRay& ray, float lightDensity);
    Vec3f origin, direction, inverse; ///< inverse: 1 / direction
    float lightDensity;
    float factor = 1; ///< one half for lights that sample one of two sides before the direction
    bool infinite;
  };
  /**
   * Density with which a ray is sampled through each box. For infinite lights: of origins across the
   * direction, uniform over the silhouette [1/area]; 0 where the ray misses. For finite lights: of
   * directions, uniform in the cone around the bounding sphere [1/sr]; 0 outside of the cone, `lightDensity`
   * where the sphere encloses the origin. `hitBoxes`: bits of the boxes that the ray hits even if rounding
   * denies it.
   */
  Float8 density(const Line& line, uint32_t hitBoxes) const {
    return line.infinite ? acrossSilhouettes(line, hitBoxes) : inCones(line, hitBoxes);
  }

 private:
  Float8 acrossSilhouettes(const Line& line, uint32_t hitBoxes) const;
  Float8 inCones(const Line& line, uint32_t hitBoxes) const;

  std::array<Float8, 3> lower{zero(), zero(), zero()}, upper = lower, centers = lower;
  Float8 radii2 = zero();
  static Float8 zero() { return Float8(0); }
};

/** Boxes of a scene in groups of eight: first those around exits, then those around camera vertices. */
struct EmissionBoxes {
  std::vector<BoxBlock> blocks;
  std::vector<float> chances; ///< by lane of the blocks; sum to 1 over exits, and over camera vertices
  size_t exitBlocks = 0;      ///< number of the blocks that enclose exits

  /** Follows camera paths. No boxes if they have too few vertices. */
  void learn(const Scene& scene, uint64_t seed, TransportCounts& counts);
  bool empty() const { return blocks.empty(); }
};

} // namespace recurse
