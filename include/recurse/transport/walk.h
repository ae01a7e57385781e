/** @file
 * What eye walks and photon walks share: queries that are counted, and roulette.
 */
#pragma once

#include "recurse/core/sampler.h"
#include "recurse/transport/integrator.h"

namespace recurse {

/** No walk is longer than this without a chance to end, so that light caught between perfect mirrors stops.
 */
constexpr int LONG_WALK = 64;
constexpr float LONG_WALK_SURVIVAL = 0.95f;

/** Russian roulette: true to go on, and then the weight is divided by the chance. */
inline bool survives(float chance, int length, Sampler& sampler, Rgb& weight) {
  if (length > LONG_WALK) chance = std::min(chance, LONG_WALK_SURVIVAL);
  if (chance >= 1) return true;
  if (!(chance > 0) || sampler.next1D() >= chance) return false;
  weight /= chance;
  return true;
}

/** A ray from a surface point. */
inline Ray spawn(const SurfacePoint& from, const Vec3f& direction) {
  return {from.rayOrigin(direction), direction, INFINITE};
}

/**
 * The nearest surface that scatters or emits. Surfaces that do neither are not in the scene; one that emits
 * and does not scatter is returned, and the caller goes on behind it.
 */
inline bool intersect(const Scene& scene, const Ray& ray, Hit& hit, TransportCounts& counts) {
  ++counts.rays;
  return scene.intersect(ray, hit);
}

/** What a sample stands for where an eye ray has arrived, its width included. */
inline Footprint footprint(const EyeRay& ray) { return {ray.direction, ray.width * ray.sampleSpacing}; }

/** The BSDF of what a ray met, once the material has shaped the surface; null where rays pass through. */
inline const Bsdf* bsdfAt(Hit& hit, const Footprint& footprint, BsdfArena& arena) {
  if (!hit.material) return nullptr;
  hit.point.footprint = footprint;
  if (hit.material->detail) hit.material->detail->apply(hit.point);
  return hit.material->bsdfAt(hit.point, arena);
}

/** The ray that must be free for light from `target`, or from infinitely far in that direction, to reach the
 * point. Its direction is zero where there is no way between. */
inline Ray shadowRay(const SurfacePoint& from, const Illumination& light) {
  const Vec3f origin = from.rayOrigin(light.direction);
  const bool endless = light.distance == INFINITE;
  // The target is displaced from its own surface; the limit covers the rounding of the way.
  return {origin, endless ? light.direction : light.target - origin,
          endless ? INFINITE : 1 - 16 * std::numeric_limits<float>::epsilon()};
}

/** True when the light reaches the point. */
inline bool visible(const Scene& scene, const SurfacePoint& from, const Illumination& light,
                    TransportCounts& counts) {
  ++counts.rays;
  const Ray ray = shadowRay(from, light);
  return ray.direction == Vec3f(0) || !scene.occluded(ray);
}

} // namespace recurse
