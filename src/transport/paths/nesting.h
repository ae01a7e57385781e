/** @file
 * Dielectrics that overlap, by priority (Schmidt and Budge 2002, "Simple Nested Dielectrics in Ray Traced
 * Images"): where several are, the strongest is there, and the surfaces of the others count for nothing. So
 * water may reach into the glass around it, and leaves no gap.
 */
#pragma once

#include <algorithm>
#include <array>

#include "recurse/model/scene/scene.h"

namespace recurse {

/** True for a surface of a solid with priority. */
inline bool isNested(const Hit& hit) { return hit.material && hit.material->nesting >= 0; }

/** What a walk is inside of. Dielectrics are known by their places, the strongest first. */
class Nesting {
 public:
  /** The number of the medium that the walk is in. */
  uint16_t medium(const Scene& scene) const {
    for (size_t i = 0; i < scene.nestedIndices().size(); ++i)
      if (depth[i] > 0) {
        const uint16_t within = scene.nestedMedium(i);
        return within == Scene::SURROUNDING_MEDIUM ? around : within;
      }
    return around;
  }
  /** For a walk that begins in a medium. */
  void startIn(uint16_t medium) { around = medium; }
  /** The walk is about to meet a boundary: the medium on the way is the one on this side of it. Another one
   * was known where the walk began on a boundary, or where two lie in one plane, of which rays meet one. */
  void approach(const Hit& hit, const Vec3f& direction) {
    if (!hit.media.isBoundary() || isNested(hit) || depth != decltype(depth){}) return;
    around = glm::dot(direction, hit.point.geometricNormal) < 0 ? hit.media.outside : hit.media.inside;
  }
  /** The walk leaves a surface, or what looks like none, in `direction`: on that side it is in the medium
   * there. */
  void enterMedium(const Hit& hit, const Vec3f& direction) {
    if (!hit.media.isBoundary()) return;
    const bool outside = glm::dot(direction, hit.point.geometricNormal) > 0;
    if (!isNested(hit))
      around = outside ? hit.media.outside : hit.media.inside;
    else if (outside && depth == decltype(depth){})
      around = hit.media.outside;
  }

  /** Whether a ray of unit `direction` that has hit a nested dielectric interacts with its surface. False
   * where a solid of higher priority hides it: the ray passes, and is inside or outside of it from now on.
   * Else sets the refractive index outside of the point. */
  bool isTrueIntersection(const Scene& scene, Hit& hit, const Vec3f& direction) {
    const auto own = static_cast<size_t>(hit.material->nesting);
    const bool entering = glm::dot(direction, hit.point.geometricNormal) < 0;
    bool hidden = depth[own] > (entering ? 0 : 1); // within another shape of the same
    for (size_t i = 0; i < own; ++i) hidden = hidden || depth[i] > 0;
    if (hidden) {
      cross(*hit.material, entering);
      return false;
    }
    const std::vector<float>& indices = scene.nestedIndices();
    hit.point.indexOutside = 1;
    for (size_t i = own + 1; i < indices.size(); ++i)
      if (depth[i] > 0) {
        hit.point.indexOutside = indices[i];
        break;
      }
    return true;
  }

  /** For a walk that begins at a point, by all that a ray from there meets: solids are closed, so it leaves
   * once more than it enters what the point is inside of. `surfaces(f)` calls f(hit, direction) for each. */
  template <class Surfaces> static Nesting within(const Surfaces& surfaces) {
    std::array<int, Scene::MAX_NESTED> left{};
    surfaces([&](const Hit& hit, const Vec3f& direction) {
      if (isNested(hit))
        left[static_cast<size_t>(hit.material->nesting)] +=
            glm::dot(direction, hit.point.geometricNormal) < 0 ? -1 : 1;
    });
    Nesting nesting;
    for (size_t i = 0; i < left.size(); ++i) nesting.depth[i] = static_cast<uint8_t>(std::max(left[i], 0));
    return nesting;
  }

  /** The walk came from `wi` and goes on to `direction`, which may be through the surface. */
  void scatters(const Hit& hit, const Vec3f& wi, const Vec3f& direction) {
    if (isNested(hit)) {
      const float before = glm::dot(wi, hit.point.geometricNormal);
      if (before * glm::dot(direction, hit.point.geometricNormal) < 0) cross(*hit.material, before > 0);
    }
    enterMedium(hit, direction);
  }

 private:
  void cross(const Material& material, bool entering) {
    uint8_t& d = depth[static_cast<size_t>(material.nesting)];
    if (entering)
      ++d;
    else if (d > 0) // shapes may be open
      --d;
  }

  std::array<uint8_t, Scene::MAX_NESTED> depth{}; ///< how many shapes of each it is inside of
  uint16_t around = 0;                            ///< the medium outside of all of them
};

} // namespace recurse
