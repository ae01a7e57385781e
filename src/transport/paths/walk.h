/** @file
 * Functions shared by walks from the camera and from the lights: counted intersection queries, Russian
 * roulette, visibility.
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
#include "transport/paths/opticalPath.h"

namespace recurse {

/** Maximum number of scattering events up to which a camera path branches. */
constexpr int MAX_BRANCHING_DEPTH = 64;
/** Number of scattering events after which lossless paths, as between perfect mirrors, undergo roulette. */
constexpr int LOSSLESS_ROULETTE_DEPTH = 512;

/** Loss of a scattering event below which a path counts as lossless. */
constexpr float NOTHING_LOST = 1e-5f;

/**
 * Russian roulette with survival probability `chance`: returns true to continue, with the weight divided by
 * it. Lossless paths survive n events with probability (512/n)², since a probability below the squared albedo
 * would give infinite variance.
 */
inline bool russianRoulette(float chance, int length, Sampler& sampler, Rgb& weight) {
  if (length > LOSSLESS_ROULETTE_DEPTH && chance > 1 - NOTHING_LOST)
    chance = std::min(chance, 1 - 2 / static_cast<float>(length));
  if (chance >= 1) return true;
  if (!(chance > 0) || sampler.next1D() >= chance) return false;
  weight /= chance;
  return true;
}

/**
 * Russian roulette of a camera path of `length` scattering events. The path survives its first two events,
 * and later ones while its throughput is at least 1/2. Below, the survival probability is twice the
 * throughput. Roulette at the first events would be most of the noise under smooth light. A probability equal
 * to the throughput would leave light of several bounces to few paths of large weight. `etaScale`: undoes the
 * 1/η² of radiance inside glass. `left`: fraction of the path's light that other estimates leave to it.
 */
inline bool cameraRoulette(float etaScale, int length, Sampler& sampler, Rgb& throughput, float left = 1) {
  constexpr int FREE = 2;
  constexpr float CERTAIN = 0.5f;
  if (length <= FREE) return true;
  const float radianceWeight = maxComponent(throughput) * etaScale * left;
  if (radianceWeight > 1 - NOTHING_LOST * static_cast<float>(length))
    return russianRoulette(1, length, sampler, throughput);
  return radianceWeight >= CERTAIN || russianRoulette(radianceWeight / CERTAIN, length, sampler, throughput);
}

/** Point at distance t on a ray inside a medium, without a surface. */
inline SurfacePoint pointInMedium(const Ray& ray, float t) {
  SurfacePoint point{};
  point.position = ray.at(t);
  point.indexOutside = 1;
  point.time = ray.time;
  return point;
}

/** Ray that starts at a surface point. */
inline Ray spawn(const SurfacePoint& from, const Vec3f& direction) {
  return {from.rayOrigin(direction), direction, INFINITE, from.time};
}

/**
 * Finds the nearest surface that scatters or emits. Surfaces that do neither are not part of the scene. For a
 * surface that emits without scattering, the caller continues the ray behind it.
 */
inline bool intersect(const Scene& scene, const Ray& ray, Hit& hit, TransportCounts& counts) {
  ++counts.rays;
  return scene.intersect(ray, hit);
}

/** Finds only the position of the nearest surface: see Scene::intersectPosition(). */
inline bool intersectPosition(const Scene& scene, const Ray& ray, Hit& hit, TransportCounts& counts) {
  ++counts.rays;
  return scene.intersectPosition(ray, hit);
}

/** See Scene::probePosition(). */
inline bool probePosition(const Scene& scene, const Ray& ray, Hit& hit, TransportCounts& counts) {
  ++counts.rays;
  return scene.probePosition(ray, hit);
}

/** Sets the wavelength at which a dispersive surface refracts, before bsdfAt(): the walk's wavelength, or for
 * white light a sampled one. */
inline void drawWavelength(const Scene& scene, float wavelength, Sampler& sampler, Hit& hit) {
  if (!(scene.contents().lobes & DISPERSIVE) || !hit.material || !(hit.material->lobes() & DISPERSIVE))
    return;
  hit.point.isWhite = wavelength == 0;
  hit.point.wavelength = wavelength > 0 ? wavelength : sampleWavelength(sampler.next1D());
}

/** Updates the wavelength of the walk after a scattering event: refraction at a sampled wavelength fixes it.
 * Returns the colour factor of formerly white light, whose mean over wavelengths is white. */
inline Rgb dispersedColour(const SurfacePoint& point, const Scatter& s, float& wavelength) {
  if (!(point.wavelength > 0) || !point.isWhite || s.lobe != REFRACTION) return Rgb(1);
  wavelength = point.wavelength;
  return wavelengthColour(wavelength);
}

/** BSDF at a hit, after the material's surface detail has been applied; null where rays pass through. */
inline const Bsdf* bsdfAt(Hit& hit, const Footprint& footprint, BsdfArena& arena) {
  if (!hit.material) return nullptr;
  // Set member by member: a wide load right after narrow stores would stall.
  hit.point.footprint.direction = footprint.direction;
  hit.point.footprint.width = footprint.width;
  if (hit.material->detail) hit.material->detail->apply(hit.point);
  return hit.material->bsdfAt(hit.point, arena);
}

/** BSDF at a hit, with nested dielectrics resolved: null as well for surfaces hidden by a higher priority. */
inline const Bsdf* bsdfAt(const Scene& scene, Hit& hit, const Vec3f& direction, const Footprint& footprint,
                          Nesting& nesting, BsdfArena& arena) {
  if (isNested(hit) && !nesting.isTrueIntersection(scene, hit, direction)) return nullptr;
  return bsdfAt(hit, footprint, arena);
}

/** Part of the way to a light that shadow rays test: less than 1 by rounding errors. */
constexpr float REST = 1 - 16 * std::numeric_limits<float>::epsilon();

/** Shadow ray from the point to `target`, or to infinity in that direction, which is unoccluded if the light
 * is visible. Its direction is zero where both points coincide. */
inline Ray shadowRay(const SurfacePoint& from, const LiSample& light) {
  const Vec3f origin = from.rayOrigin(light.direction);
  const bool endless = light.distance == INFINITE;
  // The target is displaced from its own surface; the shortened limit covers rounding along the ray.
  return {origin, endless ? light.direction : light.target - origin, endless ? INFINITE : REST, from.time};
}

/** Dielectrics that contain the origin of this ray. */
inline Nesting nestingAt(const Scene& scene, Ray ray, TransportCounts& counts) {
  if (scene.nestedIndices().empty()) return {};
  return Nesting::within([&](const auto& crosses) {
    for (Hit hit; intersectPosition(scene, ray, hit, counts); ray = rayBehind(ray, hit))
      crosses(hit, ray.direction);
  });
}

/** Refractive index at the origin of a ray, in the state `nesting`; that of dielectrics without a priority
 * counts in transient renders only. */
inline float indexAtStart(const Scene& scene, const PathClasses& classes, Ray ray, const Nesting& nesting,
                          TransportCounts& counts) {
  const float index = nesting.index(scene);
  if (!classes.isTransient() || !(scene.contents().lobes & (REFRACTION | TRANSMISSION))) return index;
  DielectricCrossings crossings;
  for (Hit hit; intersectPosition(scene, ray, hit, counts); ray = rayBehind(ray, hit))
    crossings.add(hit, ray.direction);
  return index * crossings.indexAtOrigin();
}

/** Optical path at the start of a light path along a ray, in the state `nesting`. */
inline OpticalPath opticalStart(const Scene& scene, const PathClasses& classes, const Ray& ray,
                                const Nesting& nesting, bool isInfinite, TransportCounts& counts) {
  return {isInfinite ? lengthFromInfinity(scene, ray.origin, -ray.direction) : 0,
          indexAtStart(scene, classes, ray, nesting, counts)};
}

inline bool hasPanes(const Scene& scene) { return (scene.contents().lobes & STRAIGHT) != 0; }

/** Whether the event passed straight through a thin pane, as shadow rays also do. */
inline bool passesPane(const Scene& scene, const ScatteringPoint& scattering, const Scatter& s) {
  return s.lobe == REFRACTION && (scattering.lobes() & STRAIGHT) && hasPanes(scene);
}

/** Fraction of the radiance transmitted straight through thin panes at `scattering`, seen from unit `wi`;
 * black without a pane. */
inline Rgb paneTransmittance(const ScatteringPoint& scattering, const Vec3f& wi) {
  Rgb sum = BLACK;
  if (!(scattering.lobes() & STRAIGHT)) return sum;
  std::array<Scatter, DeltaScatters::MAX_COUNT> all;
  const int count = scattering.deltaScatters(wi, Transport::RADIANCE, all);
  for (int i = 0; i < count; ++i)
    if (all[size_t(i)].lobe == REFRACTION) sum += all[size_t(i)].weight;
  return sum;
}

/** Number of panes that a shadow ray may pass from the surface that is event number `depth` of its path. A
 * maxDepth of -1 means any number. */
inline int panesLeft(int maxDepth, int depth) {
  return maxDepth < 0 ? std::numeric_limits<int>::max() : std::max(0, maxDepth - depth);
}

/** Callback that does nothing. */
struct Ignore {
  template <class... Arguments> void operator()(const Arguments&...) const {}
};

/** Kind of the surface of a hit in the path classes. */
inline SurfaceKind surfaceKind(const PathClasses& classes, const Hit& hit) {
  return classes.surfaceKind(hit.object, hit.material ? hit.material->number : 0);
}

/** Camera path that a shadow ray continues through thin panes, each an S event of the path. */
struct PaneSteps {
  const PathClasses& classes;
  CameraState state;
  int panes = 0;
  void operator()(const Hit& pane) {
    state = classes.step(state, PathEvent::S, surfaceKind(classes, pane));
    ++panes;
  }
};

/** State of light that a medium emits. */
inline LightState startInMedium(const Scene& scene, const PathClasses& classes, uint16_t medium) {
  return classes.lightStart(scene.lights().size() + medium - 1);
}

/** Moves the origin of a shadow ray behind a surface, and aims it at its target again: displaced only, it
 * could hit the surface of the light. Returns false where nothing of the ray is left. */
inline bool passBehind(Ray& ray, const Hit& hit, const LiSample& light) {
  ray = rayBehind(ray, hit);
  if (light.distance == INFINITE) return true;
  ray = {ray.origin, light.target - ray.origin, REST, ray.time};
  return glm::dot(ray.direction, light.direction) > 0;
}

/** Transmittance along an occluded shadow ray: up to `maxPanes` thin panes, and the surfaces hidden by nested
 * dielectrics, transmit light. `nesting` is the state of the walk that arrived at the point from `wi`. Calls
 * passed(const Hit&) for each pane on the ray. */
template <class Passed>
Rgb throughPanes(const Scene& scene, Ray ray, const Hit& from, const Vec3f& wi, const LiSample& light,
                 Nesting nesting, int maxPanes, TransportCounts& counts, Passed&& passed) {
  const bool panes = maxPanes > 0 && hasPanes(scene);
  if (!panes && scene.nestedIndices().empty()) return BLACK;
  Rgb value(1);
  nesting.scatters(from, wi, light.direction);
  BsdfArena arena;
  Hit hit;
  int count = 0;
  while (panes ? intersect(scene, ray, hit, counts) : intersectPosition(scene, ray, hit, counts)) {
    if (hit.material && !(isNested(hit) && !nesting.isTrueIntersection(scene, hit, light.direction))) {
      if (count++ == maxPanes || !panes) return BLACK;
      arena.reset();
      const Bsdf* bsdf = bsdfAt(hit, Footprint(), arena);
      if (!bsdf) return BLACK;
      value *= paneTransmittance(ScatteringPoint(*bsdf, hit.point), -light.direction);
      if (isBlack(value)) return BLACK;
      passed(hit);
    }
    if (!passBehind(ray, hit, light)) break;
  }
  return value;
}

/** Transmittance from the light to the point, at which a walk arrived from `wi`. Calls passed(const
 * Hit&) for each pane on the ray. */
template <class Passed = Ignore>
Rgb transmittance(const Scene& scene, const Hit& from, const Vec3f& wi, const LiSample& light,
                  const Nesting& nesting, int maxPanes, TransportCounts& counts, Passed&& passed = {}) {
  ++counts.rays;
  const Ray ray = shadowRay(from.point, light);
  if (ray.direction == Vec3f(0) || !scene.occluded(ray)) return Rgb(1);
  return throughPanes(scene, ray, from, wi, light, nesting, maxPanes, counts, passed);
}

/** True if no scattering surface, not even a thin pane, is between the light and the point. */
inline bool visible(const Scene& scene, const Hit& from, const Vec3f& wi, const LiSample& light,
                    const Nesting& nesting, TransportCounts& counts) {
  return !isBlack(transmittance(scene, from, wi, light, nesting, 0, counts));
}

} // namespace recurse
