/** @file
 * Random walks to the surfaces that enclose a place.
 */
#include "recurse/model/scene/surroundingMedium.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "recurse/core/sampling/sampler.h"
#include "recurse/core/sampling/sampling.h"

namespace recurse {

namespace {

/** Numbers of walks that found a medium, by its index. */
using Votes = std::vector<size_t>;

std::optional<uint16_t> mostFrequent(const Votes& votes) {
  const auto most = std::max_element(votes.begin(), votes.end());
  if (*most == 0) return {};
  return static_cast<uint16_t>(most - votes.begin());
}

/** Adds the medium at the origin of the ray to `byBoundaries` if the walk reaches a boundary that light
 * passes, and to `bySurfaces` the media that other surfaces on the way are in. */
void addMedium(const Scene& scene, Ray ray, Sampler& sampler, Votes& byBoundaries, Votes& bySurfaces,
               uint64_t& traced) {
  constexpr int MAX_SURFACES = 16;
  Hit hit;
  for (int i = 0; i < MAX_SURFACES; ++i) {
    ++traced;
    if (!scene.intersectPosition(ray, hit)) return;
    const uint16_t here = mediumBefore(hit, ray.direction);
    if (hit.media.isBoundary() && !isOpaque(hit.material)) {
      ++byBoundaries[here];
      return;
    }
    if (hit.media.inside != 0 || hit.media.outside != 0) ++bySurfaces[here];
    if (isOpaque(hit.material)) {
      ray.direction =
          Frame(hit.point.normalTowards(-ray.direction)).toWorld(cosineHemisphere(sampler.next2D()));
      ray.origin = hit.point.rayOrigin(ray.direction);
      ray.tMax = INFINITE;
    } else {
      ray = rayBehind(ray, hit);
    }
  }
}

} // namespace

SurroundingMedium mediumAround(const Scene& scene, std::span<const Ray> rays, uint16_t named,
                               uint64_t& traced) {
  Votes byBoundaries(scene.mediumCount() + 1), bySurfaces = byBoundaries;
  Sampler sampler(0, 0, 0);
  for (const Ray& ray : rays) addMedium(scene, ray, sampler, byBoundaries, bySurfaces, traced);
  const auto without = static_cast<size_t>(std::count(byBoundaries.begin(), byBoundaries.end(), 0));
  if (const auto medium = mostFrequent(byBoundaries)) return {*medium, without + 1 < byBoundaries.size()};
  return {named != 0 ? named : mostFrequent(bySurfaces).value_or(0)};
}

} // namespace recurse
