/** @file
 * Form factors by rays.
 */
#include "recurse/report/inspect/formFactors.h"

#include <algorithm>

#include "recurse/core/sampling/sampling.h"
#include "recurse/core/threads/parallel.h"

namespace recurse {

namespace {

/** Patch at the first surface on the ray that scatters. */
std::optional<uint32_t> patchOnRay(const Scene& scene, const Integrator& integrator, Ray ray) {
  Hit hit;
  BsdfArena arena;
  while (scene.intersect(ray, hit)) {
    arena.reset();
    if (hit.material && hit.material->bsdfAt(hit.point, arena)) return integrator.patchAt(hit);
    ray = rayBehind(ray, hit);
  }
  return {};
}

FormFactors factorsFrom(const Scene& scene, const Integrator& integrator, uint32_t patch, size_t side,
                        uint32_t rays, uint64_t seed) {
  std::vector<uint32_t> hits;
  for (uint32_t i = 0; i < rays; ++i) {
    Sampler sampler(seed, patch, i);
    const SurfacePoint from = integrator.samplePatch(patch, sampler);
    const Vec3f normal = side == 0 ? from.geometricNormal : -from.geometricNormal;
    const Vec3f direction = Frame(normal).toWorld(cosineHemisphere(sampler.next2D()));
    if (const auto found =
            patchOnRay(scene, integrator, {from.rayOrigin(direction), direction, INFINITE, from.time}))
      hits.push_back(*found);
  }
  std::sort(hits.begin(), hits.end());
  FormFactors out{side, {}};
  for (const uint32_t hit : hits) {
    if (out.hits.empty() || out.hits.back().patch != hit) out.hits.push_back({hit, 0});
    ++out.hits.back().rays;
  }
  return out;
}

} // namespace

std::vector<FormFactors> formFactors(const Scene& scene, const Integrator& integrator,
                                     std::span<const RadiosityPatch> patches, uint32_t raysPerPatch,
                                     uint64_t seed, const std::atomic<bool>& stop) {
  std::vector<FormFactors> out(patches.size());
  parallelFor(patches.size(), [&](size_t i) {
    if (stop) return;
    const auto lightOn = [&](size_t side) { return luminance(patches[i].received[side]); };
    out[i] = factorsFrom(scene, integrator, static_cast<uint32_t>(i), lightOn(1) > lightOn(0) ? 1 : 0,
                         raysPerPatch, seed);
  });
  return out;
}

uint32_t formFactorRays(size_t patches) {
  constexpr size_t ALL_RAYS = 4000000, LEAST = 64, MOST = 16384;
  if (patches > MOST_FACTOR_PATCHES) return 0;
  return static_cast<uint32_t>(std::clamp(ALL_RAYS / std::max<size_t>(1, patches), LEAST, MOST));
}

} // namespace recurse
