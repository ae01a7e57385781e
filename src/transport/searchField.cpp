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
                        Kernel kernel, TransportCounts& counts) {
  this->limit = limit;
  lift = 2 * scene.bounds().radius;
  // A small picture does not look long enough at the places to be worth many.
  constexpr size_t EVERY = 4, LEAST = 1024, MOST = 65536, AT_ONCE = 64;
  const size_t pixels = size_t(scene.film().width) * size_t(scene.film().height);
  const size_t every = std::max(EVERY, first.size() / std::clamp(4 * pixels, LEAST, MOST));
  places.assign((first.size() + every - 1) / every, {});
  std::vector<Photon> lifted(places.size());
  const size_t parts = (places.size() + AT_ONCE - 1) / AT_ONCE;
  std::vector<TransportCounts> partCounts(parts);
  parallelFor(parts, [&](size_t part) {
    PhotonScratch scratch;
    for (size_t i = part * AT_ONCE; i < std::min(places.size(), (part + 1) * AT_ONCE); ++i) {
      Photon& photon = lifted[i];
      photon.position = first.position(i * every);
      photon.direction = first.packedDirection(i * every);
      GatherRegion region;
      region.center = photon.position;
      region.bothSides = true;
      const auto radius = [&] {
        region.radius = limit;
        if (nearest == 0) return limit;
        const NearestPhotons n = first.nearest(region, nearest, scratch);
        return n.count == nearest ? std::sqrt(n.radius2) : limit;
      };
      SurfacePoint point;
      if (!surfaceOf(scene, photon, radius(), point, partCounts[part])) continue;
      region.center = point.position;
      region.normal = point.geometricNormal;
      region.bothSides = false;
      region.flatness = flatness;
      Place& place = places[i];
      const float error = glm::length(point.error);
      region.radius = radius();
      Surroundings surroundings{scene, Sampler(0, 0, static_cast<uint32_t>(i))};
      fitToSurface(surroundings, error, kernel, region, partCounts[part]);
      place = {point.position, point.geometricNormal, region.radius, {}};
      photon.position = point.position + lift * point.geometricNormal;
      constexpr float BEYOND = 2; // what searches near the place may need
      region.radius *= BEYOND;
      place.around = lookAround(scene, error, region, surroundings.sampler, partCounts[part]);
    }
  });
  for (const TransportCounts& c : partCounts) counts.add(c);
  index.build(lifted);
}

SearchPlace SearchField::at(const Vec3f& position, const Vec3f& normal) const {
  constexpr int NEAREST = 4;
  thread_local PhotonScratch scratch;
  GatherRegion region;
  region.center = position + lift * normal;
  region.bothSides = true;
  index.nearest(region, NEAREST, scratch);
  SearchPlace best{limit, nullptr, INFINITE};
  index.visitNearest(scratch, [&](const PhotonBlock& block) {
    for (uint32_t rest = block.mask; rest != 0; rest &= rest - 1) {
      const size_t slot = block.first + static_cast<size_t>(std::countr_zero(rest));
      const Place& place = places[index.emissionIndex(slot)];
      const float away = glm::distance(position, place.position);
      if (place.radius == 0) continue;
      // A place on another side or behind a wall tells hardly anything.
      constexpr float ALIKE = 0.9f;
      const bool same = glm::dot(place.normal, normal) > ALIKE && place.around.sees(position);
      if (same == (best.known != nullptr) ? away < best.away : same)
        best = {place.radius, same ? &place.around : nullptr, away};
    }
  });
  // Where the place is far, there is no telling how far the k-th photon is; as far as the place, at least.
  best.radius = std::min(limit, std::max(best.radius, best.away));
  return best;
}

} // namespace recurse
