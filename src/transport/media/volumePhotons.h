/** @file
 * Volume photons at scattering events in media, and their estimate along a camera ray (Jarosz, Zwicker and
 * Jensen 2008, "The Beam Radiance Estimate for Volumetric Photon Mapping"): each photon is a disc
 * perpendicular to the ray, with a radius of its own.
 */
#pragma once

#include <array>
#include <vector>

#include "recurse/core/math/ray.h"
#include "recurse/model/scene/scene.h"
#include "recurse/transport/integrator/integrator.h"
#include "transport/media/boxPyramid.h"
#include "transport/photonmap/photon.h"

namespace recurse {

/** Photon at a scattering event in a medium. */
struct VolumePhoton {
  Vec3f position;
  PackedDirection direction; ///< unit, direction of flight
  Rgb power;                 ///< flux that is scattered, without the absorbed part [W]
  uint16_t medium = 0;       ///< index of the medium in the scene
  uint8_t pathState = 0;     ///< LightState after the events before this one
  float pathLength = 0;      ///< optical length from the light [scene units], in transient renders
};

/** Bounds of a photon's disc: the planes of the surfaces around it. */
class DiscBounds {
 public:
  /** Adds the surface at a distance [scene units]; `normal` is unit and points away from the photon. */
  void add(const Vec3f& normal, float distance);
  bool full() const { return count == MAX_COUNT; }
  bool empty() const { return count == 0; }
  /** Whether a point, relative to the photon, is beyond a surface. */
  bool cuts(const Vec3f& away) const;
  /** Fraction of the kernel's integral over the disc perpendicular to unit `direction` that is within the
   * bounds; never 0. */
  float fraction(const Vec3f& direction, float radius) const;
  /** Distance along `direction` from the bounding surface on which a ray starts, within `tolerance`, to the
   * photon; `t` if it starts on none. `origin`: origin of the ray, relative to the photon. */
  float distanceFromSurface(const Vec3f& origin, const Vec3f& direction, float t, float tolerance) const;

 private:
  static constexpr size_t MAX_COUNT = 3;
  struct Plane {
    Vec3f normal;
    float distance;
  };
  std::array<Plane, MAX_COUNT> planes;
  size_t count = 0;
};

/** Photons of a pass in a complete binary tree of boxes; immutable once built. */
class VolumePhotonMap {
 public:
  /** Builds the map. `scale`: factor on the radii that the photons' density calls for; `widest`: their
   * maximum before scaling [scene units]. Independent of the number of threads. */
  void build(std::vector<VolumePhoton> photons, float scale, float widest);
  /** Finds surfaces within the radii. The part of a disc beyond them is cut off, and the kernel is
   * renormalised on the remaining part. */
  void findBounds(const Scene& scene, float time, TransportCounts& counts);
  size_t size() const { return photons.size(); }
  size_t memoryBytes() const {
    return photons.capacity() * sizeof(VolumePhoton) + radii.capacity() * sizeof(float) + tree.memoryBytes() +
           boundsOf.capacity() * sizeof(uint32_t) + bounds.capacity() * sizeof(DiscBounds);
  }

  /** Calls visit(photon, depth, kernel) for each photon whose disc the ray of unit direction crosses between
   * 0 and `end`. `depth`: distance to the disc; if the ray starts on a surface that bounds the disc, distance
   * along the ray from there to the photon itself. `kernel` [1/area]: across the ray, with integral 1 over
   * the disc. */
  template <class Visit> void visitAlong(const Ray& ray, float end, const Visit& visit) const {
    tree.visitAlong(ray, end, [&](size_t i) {
      const Vec3f offset = photons[i].position - ray.origin;
      const float t = glm::dot(offset, ray.direction), radius2 = square(radii[i]);
      const float distance2 = lengthSquared(offset - ray.direction * t);
      if (!(t > 0 && t < end && distance2 < radius2)) return;
      float kernel = 2 * INV_PI / radius2 * (1 - distance2 / radius2); // Epanechnikov kernel on the disc
      float depth = t;
      if (!boundsOf.empty() && boundsOf[i] != NO_BOUNDS) {
        const DiscBounds& b = bounds[boundsOf[i]];
        if (b.cuts(ray.direction * t - offset)) return;
        kernel /= b.fraction(ray.direction, radii[i]);
        depth = b.distanceFromSurface(-offset, ray.direction, t, radii[i] / 2);
      }
      visit(photons[i], depth, kernel);
    });
  }

 private:
  BoxPyramid tree; ///< tree of the discs
  std::vector<VolumePhoton> photons;
  std::vector<float> radii;
  static constexpr uint32_t NO_BOUNDS = UINT32_MAX;
  std::vector<uint32_t> boundsOf; ///< index into `bounds` by photon; empty if bounds are unused
  std::vector<DiscBounds> bounds;
};

} // namespace recurse
