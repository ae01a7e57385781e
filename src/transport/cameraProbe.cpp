/** @file
 * Eye rays on a grid, followed to what they read the photon map at.
 */
#include "recurse/transport/cameraProbe.h"

#include <algorithm>
#include <array>
#include <optional>

#include "recurse/model/scatteringPoint.h"

namespace recurse {

namespace {

std::optional<VisiblePoint> firstDiffuse(const Scene& scene, CameraRay ray, Sampler sampler,
                                         const GatherWeighting& weighting, TransportCounts& counts) {
  BsdfArena arena;
  Hit hit;
  Nesting nesting = nestingAt(scene, ray, counts);
  for (int depth = 0; depth < LONG_WALK; ++depth) {
    if (!intersect(scene, ray, hit, counts)) return {};
    ray.width += ray.spread * hit.t;
    arena.reset();
    const Bsdf* bsdf = bsdfAt(scene, hit, ray.direction, Footprint(), nesting, arena);
    Vec3f direction = ray.direction;
    if (bsdf) {
      const ScatteringPoint scattering(*bsdf, hit.point);
      if (scattering.hasNonDelta()) {
        std::optional<Scatter> s;
        const bool kept = scattering.keepsPhotons();
        if (!kept || (weighting.ever() && !(scattering.lobes() & LAMBERTIAN)))
          s = scattering.scatterNonDelta(-ray.direction, Transport::RADIANCE, sampler);
        if (!kept && !s) return {};
        if (kept && (!s || weighting.followed(s->pdf) < 0.5f)) {
          hit.point.geometricNormal = hit.point.normalTowards(-ray.direction);
          return VisiblePoint{hit.point, ray.width};
        }
        direction = s->direction;
      } else {
        std::array<Scatter, DeltaScatters::MAX_COUNT> all;
        const int count = scattering.deltaScatters(-ray.direction, Transport::FLUX, all);
        if (count == 0) return {};
        direction =
            std::max_element(all.begin(), all.begin() + count, [](const Scatter& a, const Scatter& b) {
              return maxComponent(a.weight) < maxComponent(b.weight);
            })->direction;
      }
    }
    if (bsdf) nesting.scatters(hit, -ray.direction, direction);
    static_cast<Ray&>(ray) = spawn(hit.point, direction);
  }
  return {};
}

} // namespace

std::vector<VisiblePoint> probeCamera(const Scene& scene, int across, uint64_t seed,
                                      const GatherWeighting& weighting, TransportCounts& counts) {
  std::vector<VisiblePoint> seen;
  const PixelBounds film = scene.film().whole();
  for (int y = 0; y < across; ++y)
    for (int x = 0; x < across; ++x) {
      Sampler sampler(seed, static_cast<uint64_t>(y), static_cast<uint32_t>(x));
      CameraSample sample{film.middleOfCell(x, y, across)};
      if (scene.camera().usesLens()) sample.lens = sampler.next2D();
      if (scene.moves()) sample.time = scene.camera().timeAt(sampler.next1D());
      const std::optional<CameraRay> ray = scene.camera().validRay(sample);
      if (!ray) continue;
      if (const auto place = firstDiffuse(scene, *ray, sampler, weighting, counts)) seen.push_back(*place);
    }
  return seen;
}

VisibleRegion probeRegion(const Scene& scene, const GatherWeighting& weighting, TransportCounts& counts) {
  constexpr int PROBES = 96;
  const float spacing = std::sqrt(float(scene.film().whole().area())) / PROBES;
  VisibleRegion region;
  for (const VisiblePoint& place : probeCamera(scene, PROBES, 1, weighting, counts))
    if (place.footprint > 0) region.add(place.point.position, place.footprint * std::max(spacing, 2.0f));
  return region;
}

} // namespace recurse
