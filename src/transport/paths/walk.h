/** @file
 * What walks from the camera and from lights share: counted intersection queries, Russian roulette,
 * visibility.
 */
#pragma once

#include <array>
#include <limits>

#include "recurse/core/sampling/sampler.h"
#include "recurse/model/bsdf/dispersion.h"
#include "recurse/model/bsdf/scatteringPoint.h"
#include "recurse/model/bsdf/surfaceDetail.h"
#include "recurse/transport/integrator/integrator.h"
#include "transport/paths/mediumFlight.h"
#include "transport/paths/nesting.h"

namespace recurse {

/** A camera path of more scattering events does not branch. */
constexpr int MAX_BRANCHING_DEPTH = 64;
/** Paths that lose no energy, as between perfect mirrors, play roulette beyond so many scattering events. */
constexpr int LOSSLESS_ROULETTE_DEPTH = 512;

/**
 * Russian roulette: true to go on, with the weight divided by the chance. Paths that lose no energy survive n
 * events with probability (512/n)²: a chance that stays below the squared albedo would give infinite
 * variance.
 */
inline bool russianRoulette(float chance, int length, Sampler& sampler, Rgb& weight) {
  constexpr float NOTHING_LOST = 0.99999f;
  if (length > LOSSLESS_ROULETTE_DEPTH && chance > NOTHING_LOST)
    chance = std::min(chance, 1 - 2 / static_cast<float>(length));
  if (chance >= 1) return true;
  if (!(chance > 0) || sampler.next1D() >= chance) return false;
  weight /= chance;
  return true;
}

/** Where a ray is at distance t, as a point that no surface goes through. */
inline SurfacePoint pointInMedium(const Ray& ray, float t) {
  SurfacePoint point{};
  point.position = ray.at(t);
  point.indexOutside = 1;
  point.time = ray.time;
  return point;
}

/** A ray from a surface point. */
inline Ray spawn(const SurfacePoint& from, const Vec3f& direction) {
  return {from.rayOrigin(direction), direction, INFINITE, from.time};
}

/**
 * Origin of a ray that goes on straight behind a surface. At an edge it lies behind every surface there:
 * displaced from one surface only, the ray would hit the others again and again.
 */
inline Vec3f originBehind(const Ray& ray, const Hit& hit) {
  constexpr float AT_ONCE = 2; // distance to the next surface over its error
  const Vec3f behind = hit.point.rayOrigin(ray.direction);
  if (hit.t * glm::length(ray.direction) > AT_ONCE * glm::length(hit.point.error)) return behind;
  const Vec3f normal = hit.point.normalTowards(ray.direction);
  SurfacePoint point = hit.point;
  point.position = ray.origin + normal * std::max(0.0f, glm::dot(behind - ray.origin, normal));
  return point.rayOrigin(ray.direction);
}

/**
 * The nearest surface that scatters or emits. Surfaces that do neither are not in the scene; one that emits
 * and does not scatter is returned, and the caller goes on behind it.
 */
inline bool intersect(const Scene& scene, const Ray& ray, Hit& hit, TransportCounts& counts) {
  ++counts.rays;
  return scene.intersect(ray, hit);
}

/** The same for rays that only ask where it is: see Scene::intersectPosition(). */
inline bool intersectPosition(const Scene& scene, const Ray& ray, Hit& hit, TransportCounts& counts) {
  ++counts.rays;
  return scene.intersectPosition(ray, hit);
}

/** Before bsdfAt(): a dispersive surface refracts by the wavelength of the walk, or of white light by one
 * that is drawn. */
inline void drawWavelength(const Scene& scene, float wavelength, Sampler& sampler, Hit& hit) {
  if (!(scene.contents().lobes & DISPERSIVE) || !hit.material || !(hit.material->lobes() & DISPERSIVE))
    return;
  hit.point.isWhite = wavelength == 0;
  hit.point.wavelength = wavelength > 0 ? wavelength : sampleWavelength(sampler.next1D());
}

/** After a step: light that has been refracted by a wavelength keeps it. Returns the colour that white light
 * takes on by this, in the mean white. */
inline Rgb dispersedColour(const SurfacePoint& point, const Scatter& s, float& wavelength) {
  if (!(point.wavelength > 0) || !point.isWhite || s.lobe != REFRACTION) return Rgb(1);
  wavelength = point.wavelength;
  return wavelengthColour(wavelength);
}

/** What a sample stands for where a camera ray has arrived, its width included. */
inline Footprint footprint(const CameraRay& ray) { return {ray.direction, ray.width * ray.sampleSpacing}; }

/** The BSDF of what a ray met, once the material has shaped the surface; null where rays pass through. */
inline const Bsdf* bsdfAt(Hit& hit, const Footprint& footprint, BsdfArena& arena) {
  if (!hit.material) return nullptr;
  // One by one: to read at once what has just been written in parts takes long.
  hit.point.footprint.direction = footprint.direction;
  hit.point.footprint.width = footprint.width;
  if (hit.material->detail) hit.material->detail->apply(hit.point);
  return hit.material->bsdfAt(hit.point, arena);
}

/** The same, but that solids which are there by priority hide the others. */
inline const Bsdf* bsdfAt(const Scene& scene, Hit& hit, const Vec3f& direction, const Footprint& footprint,
                          Nesting& nesting, BsdfArena& arena) {
  if (isNested(hit) && !nesting.isTrueIntersection(scene, hit, direction)) return nullptr;
  return bsdfAt(hit, footprint, arena);
}

/** The ray that must be free for light from `target`, or from infinitely far in that direction, to reach the
 * point. Its direction is zero where there is no way between. */
inline Ray shadowRay(const SurfacePoint& from, const LiSample& light) {
  const Vec3f origin = from.rayOrigin(light.direction);
  const bool endless = light.distance == INFINITE;
  // The target is displaced from its own surface; the limit covers the rounding of the way.
  return {origin, endless ? light.direction : light.target - origin,
          endless ? INFINITE : 1 - 16 * std::numeric_limits<float>::epsilon(), from.time};
}

/** What a walk that begins with this ray is inside of. */
inline Nesting nestingAt(const Scene& scene, Ray ray, TransportCounts& counts) {
  if (scene.nestedIndices().empty()) return {};
  return Nesting::within([&](const auto& crosses) {
    for (Hit hit; intersectPosition(scene, ray, hit, counts); ray = spawn(hit.point, ray.direction))
      crosses(hit, ray.direction);
  });
}

inline bool hasPanes(const Scene& scene) { return (scene.contents().lobes & STRAIGHT) != 0; }

/** Whether a step went straight through a thin pane, where shadow rays go too. */
inline bool passesPane(const Scene& scene, const ScatteringPoint& scattering, const Scatter& s) {
  return s.lobe == REFRACTION && (scattering.lobes() & STRAIGHT) && hasPanes(scene);
}

/** The part of the radiance that goes straight on where `scattering` is met from unit `wi`; black without a
 * thin pane. */
inline Rgb paneTransmittance(const ScatteringPoint& scattering, const Vec3f& wi) {
  Rgb sum = BLACK;
  if (!(scattering.lobes() & STRAIGHT)) return sum;
  std::array<Scatter, DeltaScatters::MAX_COUNT> all;
  const int count = scattering.deltaScatters(wi, Transport::RADIANCE, all);
  for (int i = 0; i < count; ++i)
    if (all[size_t(i)].lobe == REFRACTION) sum += all[size_t(i)].weight;
  return sum;
}

/** What of a light's radiance comes straight to a point. Each pane on its way is an S of the path. */
struct Transmittance {
  Rgb value{0};
  int panes = 0;
};

/** For estimators that find light behind panes by other ways. */
constexpr int NO_PANES = 0;

/** How many panes a shadow ray may pass from a surface that is event number `depth` of its path; maxDepth -1:
 * any number. */
inline int panesLeft(int maxDepth, int depth) {
  return maxDepth < 0 ? std::numeric_limits<int>::max() : std::max(0, maxDepth - depth);
}

/** For those who do not ask which panes a shadow ray passed. */
struct IgnorePane {
  void operator()(const SurfacePoint&) const {}
};

/** The transmittance along a shadow ray that meets something: up to `maxPanes` thin panes, and surfaces that
 * solids with priority hide, let light through. `nesting` is what the walk is inside of that came to the
 * point from `wi`. Calls passed(const SurfacePoint&) for each pane on the way. */
template <class Passed = IgnorePane>
Transmittance throughPanes(const Scene& scene, Ray ray, const Hit& from, const Vec3f& wi,
                           const LiSample& light, Nesting nesting, int maxPanes, TransportCounts& counts,
                           const Passed& passed = {}) {
  const bool panes = maxPanes > 0 && hasPanes(scene);
  if (!panes && scene.nestedIndices().empty()) return {};
  Transmittance sum{Rgb(1), 0};
  nesting.scatters(from, wi, light.direction);
  BsdfArena arena;
  Hit hit;
  while (panes ? intersect(scene, ray, hit, counts) : intersectPosition(scene, ray, hit, counts)) {
    if (hit.material && !(isNested(hit) && !nesting.isTrueIntersection(scene, hit, light.direction))) {
      if (sum.panes++ == maxPanes || !panes) return {};
      arena.reset();
      const Bsdf* bsdf = bsdfAt(hit, Footprint(), arena);
      if (!bsdf) return {};
      sum.value *= paneTransmittance(ScatteringPoint(*bsdf, hit.point), -light.direction);
      if (isBlack(sum.value)) return {};
      passed(hit.point);
    }
    ray = shadowRay(hit.point, light);
    if (ray.direction == Vec3f(0)) break;
  }
  return sum;
}

/** What of the light comes straight to the point, to which a walk came from `wi`. Calls passed(const
 * SurfacePoint&) for each pane on the way. */
template <class Passed = IgnorePane>
Transmittance transmittance(const Scene& scene, const Hit& from, const Vec3f& wi, const LiSample& light,
                            const Nesting& nesting, int maxPanes, TransportCounts& counts,
                            const Passed& passed = {}) {
  ++counts.rays;
  const Ray ray = shadowRay(from.point, light);
  if (ray.direction == Vec3f(0) || !scene.occluded(ray)) return {Rgb(1), 0};
  return throughPanes(scene, ray, from, wi, light, nesting, maxPanes, counts, passed);
}

/** True when nothing that scatters, panes included, is between the light and the point. */
inline bool visible(const Scene& scene, const Hit& from, const Vec3f& wi, const LiSample& light,
                    const Nesting& nesting, TransportCounts& counts) {
  return !isBlack(transmittance(scene, from, wi, light, nesting, 0, counts).value);
}

} // namespace recurse
