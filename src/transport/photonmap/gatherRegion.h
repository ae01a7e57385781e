/** @file
 * Where photons are searched.
 */
#pragma once

#include <algorithm>
#include <array>

#include "recurse/core/math/vector.h"

namespace recurse {

/** A spheroid around a surface point, flattened along the normal: with v = photon − center, h = v·normal and
 * w = max(0, 1/flatness² − 1), photons where |v|² + w h² < radius². The flattening is part of the metric, so
 * that the k nearest photons are those that a fixed-radius query finds at the distance of the k-th.
 *
 * Where !bothSides, a photon counts only if its surface faces the same way to within 60°, so that the other
 * side of a thin wall lends no light. Half-spaces clip the region: photons where v·normal > limit for all. */
struct GatherRegion {
  struct HalfSpace {
    Vec3f normal{0};
    float limit = 0; ///< negative where the centre is inside
    bool has(const Vec3f& v) const { return glm::dot(v, normal) > limit; }
  };
  static constexpr size_t MAX_CLIPS = 6;
  static constexpr float MIN_COSINE = 0.5f; ///< between normals of a photon and of the region

  Vec3f center{0};
  Vec3f normal{0, 0, 1};   ///< unit, geometric, on the side that photons must arrive from
  float radius = INFINITE; ///< on the tangent plane [scene units]; may be infinite for k-nearest
  float flatness = 1;      ///< half axis along the normal ÷ radius, at least 1e-6; from 1 on: a sphere
  bool bothSides = false;  ///< photons may arrive from either side (transmitting surfaces)
  size_t clipCount = 0;
  std::array<HalfSpace, MAX_CLIPS> clips{}; ///< the first clipCount of them

  /** Whether no half-space takes the point center + v away. */
  bool unclipped(const Vec3f& v) const {
    return std::all_of(clips.begin(), clips.begin() + clipCount,
                       [&](const HalfSpace& clip) { return clip.has(v); });
  }
  /** D² of center + v. */
  float distance2(const Vec3f& v) const {
    const float h = glm::dot(v, normal);
    return lengthSquared(v) + std::max(0.0f, 1 / square(flatness) - 1) * square(h);
  }
};

} // namespace recurse
