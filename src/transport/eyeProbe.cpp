/** @file
 * Eye rays on a grid, followed to what they read the photon map at.
 */
#include "recurse/transport/eyeProbe.h"

#include <algorithm>
#include <array>
#include <optional>

#include "recurse/model/scatteringPoint.h"

namespace recurse {

namespace {

std::optional<SeenPlace> firstDiffuse(const Scene& scene, EyeRay ray, Sampler sampler,
                                      const LobeSharing& sharing, TransportCounts& counts) {
  BsdfArena arena;
  Hit hit;
  for (int depth = 0; depth < LONG_WALK; ++depth) {
    if (!intersect(scene, ray, hit, counts)) return {};
    ray.width += ray.spread * hit.t;
    arena.reset();
    const Bsdf* bsdf = bsdfAt(hit, Footprint(), arena);
    Vec3f direction = ray.direction;
    if (bsdf) {
      const ScatteringPoint scattering(*bsdf, hit.point);
      if (scattering.hasDiffuse()) {
        std::optional<Scatter> s;
        if (sharing.ever() && !(scattering.lobes() & LAMBERTIAN))
          s = scattering.scatterDiffuse(-ray.direction, Transport::RADIANCE, sampler);
        if (!s || sharing.followed(s->pdf) < 0.5f) {
          hit.point.geometricNormal = hit.point.normalTowards(-ray.direction);
          return SeenPlace{hit.point, ray.width};
        }
        direction = s->direction;
      } else {
        std::array<Scatter, DeltaScatters::MOST> all;
        const int count = scattering.deltaScatters(-ray.direction, Transport::FLUX, all);
        if (count == 0) return {};
        direction =
            std::max_element(all.begin(), all.begin() + count, [](const Scatter& a, const Scatter& b) {
              return maxComponent(a.weight) < maxComponent(b.weight);
            })->direction;
      }
    }
    static_cast<Ray&>(ray) = spawn(hit.point, direction);
  }
  return {};
}

} // namespace

std::vector<SeenPlace> probeEye(const Scene& scene, int across, uint64_t seed, const LobeSharing& sharing,
                                TransportCounts& counts) {
  std::vector<SeenPlace> seen;
  const PixelBounds& crop = scene.film().crop;
  for (int y = 0; y < across; ++y)
    for (int x = 0; x < across; ++x) {
      const Vec2f film(float(crop.x0) + (float(x) + 0.5f) / float(across) * float(crop.width()),
                       float(crop.y0) + (float(y) + 0.5f) / float(across) * float(crop.height()));
      const Sampler sampler(seed, static_cast<uint64_t>(y), static_cast<uint32_t>(x));
      if (const auto place = firstDiffuse(scene, scene.camera().ray(film), sampler, sharing, counts))
        seen.push_back(*place);
    }
  return seen;
}

} // namespace recurse
