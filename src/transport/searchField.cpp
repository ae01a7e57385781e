/** @file
 * Radii and clear distances at places of a first photon map.
 */
#include "recurse/transport/searchField.h"

#include "recurse/core/parallel.h"

namespace recurse {

float radiusScale(uint32_t index, double alpha) {
  // The product over i = 1 … index of (i + alpha) / (i + 1), by gamma functions.
  const double n = double(index);
  return static_cast<float>(
      std::exp(0.5 * (std::lgamma(n + 1 + alpha) - std::lgamma(1 + alpha) - std::lgamma(n + 2))));
}

namespace {

/** Finds the surface that a photon lies on: photons do not know it. A ray that is short against `near`, from
 * where the photon came from; false when it meets nothing. */
bool surfaceOf(const Scene& scene, const Photon& photon, float near, SurfacePoint& point,
               TransportCounts& counts) {
  const Vec3f direction = unpackDirection(photon.direction);
  const float start = 0.01f * near;
  Hit hit;
  if (!intersect(scene, {photon.position + direction * start, -direction, 2 * start}, hit, counts))
    return false;
  point = hit.point;
  if (glm::dot(point.geometricNormal, direction) < 0) point.geometricNormal = -point.geometricNormal;
  return true;
}

} // namespace

void SearchField::build(const Scene& scene, const PhotonMap& first, int nearest, float limit, float flatness,
                        TransportCounts& counts) {
  this->limit = limit;
  constexpr size_t EVERY = 4, MOST = 65536, AT_ONCE = 256;
  const size_t every = std::max(EVERY, first.size() / MOST);
  std::vector<Photon> found((first.size() + every - 1) / every);
  neighbourhoods.resize(found.size());
  const size_t parts = (found.size() + AT_ONCE - 1) / AT_ONCE;
  std::vector<TransportCounts> partCounts(parts);
  parallelFor(parts, [&](size_t part) {
    PhotonScratch scratch;
    for (size_t i = part * AT_ONCE; i < std::min(found.size(), (part + 1) * AT_ONCE); ++i) {
      Photon& place = found[i];
      place.position = first.position(i * every);
      place.direction = first.packedDirection(i * every);
      GatherRegion region;
      region.center = place.position;
      region.bothSides = true;
      const auto radiusHere = [&] {
        region.radius = limit;
        if (nearest == 0) return limit;
        const NearestPhotons n = first.nearest(region, nearest, scratch);
        return n.count == nearest ? std::sqrt(n.radius2) : limit;
      };
      float radius = radiusHere();
      SurfacePoint point;
      if (surfaceOf(scene, place, radius, point, partCounts[part])) {
        place.direction = packDirection(point.geometricNormal);
        region.normal = point.geometricNormal;
        region.bothSides = false;
        region.flatness = flatness;
        radius = radiusHere();
        constexpr float BEYOND = 2; // what searches near the place may need
        region.radius = BEYOND * radius;
        Sampler sampler(0, 0, static_cast<uint32_t>(i));
        neighbourhoods[i] = lookAround(scene, glm::length(point.error), region, sampler, partCounts[part]);
      }
      place.power = Rgb(radius);
    }
  });
  for (const TransportCounts& c : partCounts) counts.add(c);
  places.build(found);
}

SearchPlace SearchField::at(const Vec3f& position, const Vec3f& normal) const {
  if (places.empty()) return {limit};
  constexpr int NEAREST = 4;
  thread_local PhotonScratch scratch;
  GatherRegion region;
  region.center = position;
  region.normal = normal;
  region.flatness = 0.2f; // rather one farther away than on another surface
  region.radius = limit;
  places.nearest(region, NEAREST, scratch);
  SearchPlace best{limit, nullptr, INFINITE};
  places.visitNearest(scratch, [&](const PhotonBlock& block) {
    for (uint32_t rest = block.mask; rest != 0; rest &= rest - 1) {
      constexpr float ALIKE = 0.9f;
      const int lane = std::countr_zero(rest);
      const float away = std::sqrt(block.distance2[lane]);
      const Neighbourhood& there =
          neighbourhoods[places.emissionIndex(block.first + static_cast<uint32_t>(lane))];
      // A place behind a wall tells nothing of this side.
      const bool same = glm::dot(block.direction(lane), normal) > ALIKE && there.sees(position);
      if (best.known ? !same || away >= best.away : !same && away >= best.away) continue;
      best = {block.power(lane).r, same ? &there : nullptr, away};
    }
  });
  // Where the place is far, there is no telling how far the k-th photon is; as far as the place, at least.
  best.radius = std::min(limit, std::max(best.radius, best.away));
  return best;
}

} // namespace recurse
