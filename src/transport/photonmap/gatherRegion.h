/** @file
 * Search region of photon-map queries.
 */
#pragma once

#include <algorithm>
#include <array>

#include "recurse/core/math/vector.h"

namespace recurse {

/** Spheroid around a surface point, flattened along the normal: with v = photon − center, h = v·normal and w
 * = max(0, 1/flatness² − 1), photons where D² = |v|² + w h² < radius². The flattening is part of the metric:
 * a k-nearest query and a fixed-radius query at the k-th photon's distance find the same photons.
 *
 * Unless bothSides is set, the normals of photons must be within 60° of the region's, which prevents light
 * leaks through thin walls. Half-spaces clip the region to photons where v·normal > limit for all of them. */
struct GatherRegion {
  struct HalfSpace {
    Vec3f normal{0};
    float limit = 0; ///< [scene units]; negative where the centre is inside
    bool has(const Vec3f& v) const { return glm::dot(v, normal) > limit; }
  };
  static constexpr size_t MAX_CLIPS = 6;
  static constexpr float MIN_COSINE = 0.5f; ///< minimum cosine between the normals of photon and region

  Vec3f center{0};
  Vec3f normal{0, 0, 1};   ///< unit, geometric, on the side that photons must arrive from
  float radius = INFINITE; ///< in the tangent plane [scene units]; may be infinite for k-nearest
  float flatness = 1;      ///< half axis along the normal ÷ radius, at least 1e-6; a sphere from 1 on
  bool bothSides = false;  ///< photons may arrive from either side (transmitting surfaces)
  float time = 0;          ///< Ray::time of probe rays for the surfaces in the region
  size_t clipCount = 0;
  std::array<HalfSpace, MAX_CLIPS> clips{}; ///< only the first clipCount are valid

  /** Whether the point center + v is inside of all half-spaces. */
  bool unclipped(const Vec3f& v) const {
    return std::all_of(clips.begin(), clips.begin() + clipCount,
                       [&](const HalfSpace& clip) { return clip.has(v); });
  }
  /** Squared distance D² of the point center + v in the metric of the region. */
  float distance2(const Vec3f& v) const {
    const float h = glm::dot(v, normal);
    return lengthSquared(v) + std::max(0.0f, 1 / square(flatness) - 1) * square(h);
  }
};

} // namespace recurse
