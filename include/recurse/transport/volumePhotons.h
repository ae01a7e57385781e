/** @file
 * Photons where media scatter, and their estimate along a ray from the camera (Jarosz, Zwicker and Jensen
 * 2008, "The Beam Radiance Estimate for Volumetric Photon Mapping"): each photon is a disc across the ray, of
 * a radius of its own.
 */
#pragma once

#include <array>
#include <vector>

#include "recurse/core/ray.h"
#include "recurse/model/scene.h"
#include "recurse/transport/integrator.h"
#include "recurse/transport/photon.h"

namespace recurse {

/** Light that a medium is about to send on. */
struct VolumePhoton {
  Vec3f position;
  PackedDirection direction; ///< unit, of the photon's flight
  Rgb power;                 ///< that is scattered: what is absorbed has been taken off [W]
  uint16_t medium = 0;       ///< its number in the scene
  uint8_t pathState = 0;     ///< LightState after the events before this one
};

/** Where a photon's disc ends: planes of the surfaces around it. */
class DiscBounds {
 public:
  /** The surface in a distance [scene units]; `normal` is unit and points away from the photon. */
  void add(const Vec3f& normal, float distance);
  bool full() const { return count == MAX_COUNT; }
  bool empty() const { return count == 0; }
  /** Whether a point, seen from the photon, lies beyond a surface. */
  bool cuts(const Vec3f& away) const;
  /** The part of the kernel's integral over the disc across `direction` that is left; nearly, where two
   * planes meet in the disc. */
  float fraction(const Vec3f& direction, float radius) const;

 private:
  static constexpr size_t MAX_COUNT = 3;
  struct Plane {
    Vec3f normal;
    float distance;
  };
  std::array<Plane, MAX_COUNT> planes;
  size_t count = 0;
};

/** The photons of a pass in a complete binary tree of boxes; immutable once built. */
class VolumePhotonMap {
 public:
  /** `scale`: of the radii over those that the photons' density calls for; `widest`: none is above. The same
   * for any number of threads. */
  void build(std::vector<VolumePhoton> photons, float scale, float widest);
  /** Finds surfaces within the radii: what of a disc lies beyond them counts no more, and the rest as much
   * more. */
  void findBounds(const Scene& scene, float time, TransportCounts& counts);
  size_t size() const { return photons.size(); }
  size_t memoryBytes() const {
    return photons.capacity() * sizeof(VolumePhoton) + radii.capacity() * sizeof(float) +
           boxes.capacity() * sizeof(Bounds3f) + boundsOf.capacity() * sizeof(uint32_t) +
           bounds.capacity() * sizeof(DiscBounds);
  }

  /** Calls visit(photon, t, kernel) for each photon near the ray of unit direction that it passes at 0 < t <
   * end; `kernel` is 1/area across the ray, and its integral over the photon's disc 1. */
  template <class Visit> void visitAlong(const Ray& ray, float end, const Visit& visit) const {
    if (photons.empty()) return;
    struct Place {
      uint32_t level, index;
    };
    Place stack[MAX_LEVELS + 1];
    int top = 0;
    stack[top++] = {0, 0};
    const Vec3f inverse = 1.0f / ray.direction;
    while (top > 0) {
      const Place p = stack[--top];
      if (!meets(boxes[(size_t(1) << p.level) - 1 + p.index], ray.origin, inverse, end)) continue;
      if (p.level < levels) {
        stack[top++] = {p.level + 1, 2 * p.index};
        stack[top++] = {p.level + 1, 2 * p.index + 1};
        continue;
      }
      for (size_t i = firstOf(p.level, p.index); i < firstOf(p.level, p.index + 1); ++i) {
        const Vec3f way = photons[i].position - ray.origin;
        const float t = glm::dot(way, ray.direction), radius2 = square(radii[i]);
        const float distance2 = lengthSquared(way - ray.direction * t);
        if (!(t > 0 && t < end && distance2 < radius2)) continue;
        float kernel = 2 * INV_PI / radius2 * (1 - distance2 / radius2); // Epanechnikov's
        if (!boundsOf.empty() && boundsOf[i] != NO_BOUNDS) {
          const DiscBounds& b = bounds[boundsOf[i]];
          if (b.cuts(ray.direction * t - way)) continue;
          kernel /= b.fraction(ray.direction, radii[i]);
        }
        visit(photons[i], t, kernel);
      }
    }
  }

 private:
  static constexpr uint32_t MAX_LEVELS = 28;
  /** Photons of a leaf, and of a part whose density tells the radius. */
  static constexpr size_t LEAF = 8;
  static constexpr uint32_t LEVELS_OF_PART = 3;

  /** Node `index` of a level has the photons from here to where the next one begins. */
  size_t firstOf(uint32_t level, size_t index) const { return photons.size() * index >> level; }
  static bool meets(const Bounds3f& box, const Vec3f& origin, const Vec3f& inverse, float end) {
    // Of a ray in the plane of a side 0 · infinity is NaN, which min and max of this order pass over.
    float enter = 0, leave = end;
    for (int a = 0; a < 3; ++a) {
      const float t0 = (box.lower[a] - origin[a]) * inverse[a], t1 = (box.upper[a] - origin[a]) * inverse[a];
      enter = std::max(enter, std::min(t0, t1));
      leave = std::min(leave, std::max(t0, t1));
    }
    return enter <= leave;
  }

  uint32_t levels = 0; ///< that of the leaves
  std::vector<VolumePhoton> photons;
  std::vector<float> radii;
  static constexpr uint32_t NO_BOUNDS = UINT32_MAX;
  std::vector<uint32_t> boundsOf; ///< by photon: its place in `bounds`; empty if they are not asked for
  std::vector<DiscBounds> bounds;
  std::vector<Bounds3f> boxes; ///< of the photons' discs, level by level
};

} // namespace recurse
