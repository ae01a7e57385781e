/** @file
 * Nested dielectrics with priorities (Schmidt and Budge 2002, "Simple Nested Dielectrics in Ray Traced
 * Images"): where several overlap, the one of highest priority fills the overlap, and rays pass the surfaces
 * of the lower ones. Water may therefore overlap the glass around it, which leaves no gap.
 */
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "recurse/model/scene/surroundingMedium.h"

namespace recurse {

/** Media and dielectrics that contain the current point; dielectrics by priority, the highest first. */
class Nesting {
 public:
  /** Index of the medium that contains the current point. */
  uint16_t medium(const Scene& scene) const {
    for (size_t i = 0; i < scene.nestedIndices().size(); ++i)
      if (depth[i] > 0) {
        const uint16_t within = scene.nestedMedium(i);
        return within == Scene::SURROUNDING_MEDIUM ? around : within;
      }
    return around;
  }
  /** Refractive index at the current point: of the dielectric with the highest priority, 1 outside of all. */
  float index(const Scene& scene) const {
    for (size_t i = 0; i < scene.nestedIndices().size(); ++i)
      if (depth[i] > 0) return scene.nestedIndices()[i];
    return 1;
  }
  /** Sets the medium outside of all nested dielectrics, where a walk begins. */
  void startIn(uint16_t medium) { around = medium; }
  /** Corrects the medium before a hit to the one on this side of the boundary. The tracked medium is wrong if
   * the walk began on a boundary, or if two boundaries are coplanar and rays hit only one of them. */
  void approach(const Hit& hit, const Vec3f& direction) {
    if (!isPassable(hit) || isNested(hit) || depth != decltype(depth){}) return;
    around = mediumBefore(hit, direction);
  }
  /** Updates the medium when the walk leaves a surface in `direction`, reflected, transmitted or passed: it
   * is in the medium on that side. */
  void enterMedium(const Hit& hit, const Vec3f& direction) {
    if (!isPassable(hit)) return;
    const bool outside = glm::dot(direction, hit.point.geometricNormal) > 0;
    if (!isNested(hit))
      around = outside ? hit.media.outside : hit.media.inside;
    else if (outside && depth == decltype(depth){})
      around = hit.media.outside;
  }

  /** Whether a ray of unit `direction` that has hit a nested dielectric interacts with its surface. False
   * where a dielectric of higher priority hides it: the ray passes, and the state is updated to the new side.
   * If true, sets the refractive index outside of the point. */
  bool isTrueIntersection(const Scene& scene, Hit& hit, const Vec3f& direction) {
    const auto dielectric = static_cast<size_t>(hit.material->nesting);
    const bool entering = glm::dot(direction, hit.point.geometricNormal) < 0;
    bool hidden = depth[dielectric] > (entering ? 0 : 1); // inside of a second shape of the same dielectric
    for (size_t i = 0; i < dielectric; ++i) hidden = hidden || depth[i] > 0;
    if (hidden) {
      cross(*hit.material, entering);
      return false;
    }
    const std::vector<float>& indices = scene.nestedIndices();
    hit.point.indexOutside = 1;
    for (size_t i = dielectric + 1; i < indices.size(); ++i)
      if (depth[i] > 0) {
        hit.point.indexOutside = indices[i];
        break;
      }
    return true;
  }

  /** State for a walk that begins at a point, from all hits of one ray: solids are closed, so the ray leaves
   * solids around the point once more than it enters them. `surfaces(f)` calls f(hit, direction) for each. */
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

  /** Updates the state at a scattering event from `wi` to `direction`, which may be a transmission. */
  void scatters(const Hit& hit, const Vec3f& wi, const Vec3f& direction) {
    if (isNested(hit)) {
      const float before = glm::dot(wi, hit.point.geometricNormal);
      if (before * glm::dot(direction, hit.point.geometricNormal) < 0) cross(*hit.material, before > 0);
    }
    enterMedium(hit, direction);
  }

 private:
  /** Boundaries that light passes. The media on both sides of others are not tracked: an opaque sheet has no
   * inside, though a MediumInterface may give it one. */
  static bool isPassable(const Hit& hit) { return hit.media.isBoundary() && !isOpaque(hit.material); }
  void cross(const Material& material, bool entering) {
    uint8_t& d = depth[static_cast<size_t>(material.nesting)];
    if (entering)
      ++d;
    else if (d > 0) // shapes may be open
      --d;
  }

  std::array<uint8_t, Scene::MAX_NESTED> depth{}; ///< number of shapes of each that contain the point
  uint16_t around = 0;                            ///< index of the medium outside of all nested dielectrics
};

/** Crossings by one ray of the surfaces of dielectrics without a priority. Solids are closed, so the ray
 * leaves those around its origin once more than it enters them. */
class DielectricCrossings {
 public:
  void add(const Hit& hit, const Vec3f& direction) {
    if (!hit.material || isNested(hit) || hit.material->indexInside() == 1) return;
    const int step = glm::dot(direction, hit.point.geometricNormal) < 0 ? -1 : 1;
    for (Count& c : left)
      if (c.material == hit.material) {
        c.times += step;
        return;
      }
    left.push_back({hit.material, step});
  }
  /** Product of the refractive indices, each relative to the outside, of the solids around the origin. */
  float indexAtOrigin() const {
    float index = 1;
    for (const Count& c : left)
      for (int i = 0; i < c.times; ++i) index *= c.material->indexInside();
    return index;
  }

 private:
  struct Count {
    const Material* material;
    int times; ///< negative at open shapes
  };
  std::vector<Count> left;
};

} // namespace recurse
