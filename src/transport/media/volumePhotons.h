/** @file
 * Photons where media scatter, and their estimate along a ray from the camera (Jarosz, Zwicker and Jensen
 * 2008, "The Beam Radiance Estimate for Volumetric Photon Mapping"): each photon is a disc across the ray, of
 * a radius of its own.
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

/** Light that a medium is about to send on. */
struct VolumePhoton {
  Vec3f position;
  PackedDirection direction; ///< unit, of the photon's flight
  Rgb power;                 ///< that is scattered: what is absorbed has been taken off [W]
  uint16_t medium = 0;       ///< its number in the scene
  uint8_t pathState = 0;     ///< LightState after the events before this one
};

/** Points of a unit disc, each of which stands for the same part of Epanechnikov's kernel. */
using KernelPoints = std::array<Vec3f, 32>;
KernelPoints kernelPointsAcross(const Vec3f& direction);

/** Where a photon's disc ends: planes of the surfaces around it. */
class DiscBounds {
 public:
  /** The surface in a distance [scene units]; `normal` is unit and points away from the photon. */
  void add(const Vec3f& normal, float distance);
  bool full() const { return count == MAX_COUNT; }
  bool empty() const { return count == 0; }
  /** Whether a point, seen from the photon, lies beyond a surface. */
  bool cuts(const Vec3f& away) const;
  /** The part of the kernel's integral over the disc that is left; never 0. */
  float fraction(const KernelPoints& points, float radius) const;
  /** Distance along `direction` from the bounding surface on which a ray starts, up to `tolerance`, to the
   * photon; `t` where it starts on none. `origin`: of the ray, relative to the photon. */
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
    return photons.capacity() * sizeof(VolumePhoton) + radii.capacity() * sizeof(float) + tree.memoryBytes() +
           boundsOf.capacity() * sizeof(uint32_t) + bounds.capacity() * sizeof(DiscBounds);
  }

  /** Calls visit(photon, depth, kernel) for each photon near the ray of unit direction that it passes within
   * 0 and `end`: `depth` is there, or where the ray comes from a surface the photon's own way from that;
   * `kernel` is 1/area across the ray, and its integral over the photon's disc 1. */
  template <class Visit> void visitAlong(const Ray& ray, float end, const Visit& visit) const {
    const KernelPoints points = boundsOf.empty() ? KernelPoints() : kernelPointsAcross(ray.direction);
    tree.visitAlong(ray, end, [&](size_t i) {
      const Vec3f offset = photons[i].position - ray.origin;
      const float t = glm::dot(offset, ray.direction), radius2 = square(radii[i]);
      const float distance2 = lengthSquared(offset - ray.direction * t);
      if (!(t > 0 && t < end && distance2 < radius2)) return;
      float kernel = 2 * INV_PI / radius2 * (1 - distance2 / radius2); // Epanechnikov's
      float depth = t;
      if (!boundsOf.empty() && boundsOf[i] != NO_BOUNDS) {
        const DiscBounds& b = bounds[boundsOf[i]];
        if (b.cuts(ray.direction * t - offset)) return;
        kernel /= b.fraction(points, radii[i]);
        depth = b.distanceFromSurface(-offset, ray.direction, t, radii[i] / 2);
      }
      visit(photons[i], depth, kernel);
    });
  }

 private:
  BoxPyramid tree; ///< of the discs
  std::vector<VolumePhoton> photons;
  std::vector<float> radii;
  static constexpr uint32_t NO_BOUNDS = UINT32_MAX;
  std::vector<uint32_t> boundsOf; ///< by photon: its place in `bounds`; empty if they are not asked for
  std::vector<DiscBounds> bounds;
};

} // namespace recurse
