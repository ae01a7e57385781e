/** @file
 * Camera rays on a grid, followed to the surfaces where the photon map is read.
 */
#include "transport/emission/cameraProbe.h"

#include <algorithm>
#include <array>
#include <optional>

#include "recurse/model/bsdf/scatteringPoint.h"

namespace recurse {

namespace {

/** First surface of the path that gathers photons. Calls along(ray, end, medium) in each medium before it. */
template <class Along>
std::optional<VisiblePoint> firstDiffuse(const Scene& scene, CameraRay ray, Sampler sampler,
                                         const GatherWeighting& weighting, TransportCounts& counts,
                                         Along&& along) {
  BsdfArena arena;
  Hit hit;
  Nesting nesting = nestingAt(scene, ray, counts);
  nesting.startIn(scene.cameraMedium());
  for (int depth = 0; depth < MAX_BRANCHING_DEPTH; ++depth) {
    const bool isHit = intersect(scene, ray, hit, counts);
    if (scene.hasMedia()) {
      if (isHit) nesting.approach(hit, ray.direction);
      if (const Medium* medium = scene.medium(nesting.medium(scene)))
        along(ray, isHit ? hit.t : INFINITE, *medium);
    }
    if (!isHit) return {};
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
          return VisiblePoint{hit.point, ray.width, (scattering.lobes() & TRANSMISSION) != 0};
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
    if (bsdf)
      nesting.scatters(hit, -ray.direction, direction);
    else
      nesting.enterMedium(hit, direction);
    static_cast<Ray&>(ray) = bsdf ? spawn(hit.point, direction) : rayBehind(ray, hit);
  }
  return {};
}

/** Calls probe(ray, sampler) for a grid of camera rays over the image. */
template <class Probe>
void forCameraRays(const Scene& scene, int resolution, uint64_t seed, const Probe& probe) {
  const PixelBounds film = scene.film().whole();
  for (int y = 0; y < resolution; ++y)
    for (int x = 0; x < resolution; ++x) {
      Sampler sampler(seed, static_cast<uint64_t>(y), static_cast<uint32_t>(x));
      CameraSample sample{film.middleOfCell(x, y, resolution)};
      if (scene.camera().usesLens()) sample.lens = sampler.next2D();
      if (scene.moves()) sample.time = scene.camera().timeAt(sampler.next1D());
      if (const std::optional<CameraRay> ray = scene.camera().validRay(sample)) probe(*ray, sampler);
    }
}

/** Adds points in media along camera rays, weighted by the squared transmittance to the camera. */
void addMedia(const Scene& scene, const GatherWeighting& weighting, VisibleRegion& region,
              TransportCounts& counts) {
  constexpr int PROBES = 32;
  constexpr float MIN_WIDTH = 1.0f / 128;    // relative to the scene's radius
  constexpr float MIN_TRANSMITTANCE = 0.03f; // smaller weights (its square) are omitted
  const float spacing = std::sqrt(float(scene.film().whole().area())) / PROBES;
  const float least = MIN_WIDTH * scene.bounds().radius;
  forCameraRays(scene, PROBES, 1, [&](const CameraRay& start, const Sampler& sampler) {
    Rgb left(1);
    Sampler flightSampler = sampler.fork(1);
    const auto along = [&](const CameraRay& ray, float end, const Medium& medium) {
      const RayTransmittance transmittance(medium, ray, end, flightSampler);
      const float last = std::min(end, 4 * scene.bounds().radius);
      for (float t = 0; t < last;) {
        const float size = std::max((ray.width + ray.spread * t) * spacing, least), middle = t + size;
        const float seen = maxComponent(left * transmittance.to(std::min(middle, end)));
        if (seen < MIN_TRANSMITTANCE) break;
        if (middle < last) region.addInMedium(ray.at(middle), size, square(seen));
        t += 2 * size;
      }
      left *= transmittance.to(end);
    };
    firstDiffuse(scene, start, sampler, weighting, counts, along);
  });
}

} // namespace

std::vector<VisiblePoint> probeCamera(const Scene& scene, int resolution, uint64_t seed,
                                      const GatherWeighting& weighting, TransportCounts& counts) {
  std::vector<VisiblePoint> seen;
  forCameraRays(scene, resolution, seed, [&](const CameraRay& ray, const Sampler& sampler) {
    const auto pass = [](const CameraRay&, float, const Medium&) {};
    if (const auto visible = firstDiffuse(scene, ray, sampler, weighting, counts, pass))
      seen.push_back(*visible);
  });
  return seen;
}

VisibleRegion probeRegion(const Scene& scene, const GatherWeighting& weighting, TransportCounts& counts) {
  constexpr int PROBES = 96;
  const float spacing = std::sqrt(float(scene.film().whole().area())) / PROBES;
  VisibleRegion region;
  for (const VisiblePoint& visible : probeCamera(scene, PROBES, 1, weighting, counts))
    if (visible.footprint > 0)
      region.add(visible.point.position, visible.footprint * std::max(spacing, 2.0f));
  if (scene.hasMedia()) addMedia(scene, weighting, region, counts);
  return region;
}

} // namespace recurse
