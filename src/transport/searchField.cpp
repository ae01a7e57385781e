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

void SearchField::build(const Scene& scene, const PhotonMap& first, std::span<const SurfacePoint> seen,
                        int nearest, float limit, float flatness, Kernel kernel, TransportCounts& counts) {
  this->limit = limit;
  lift = 2 * scene.bounds().radius;
  // A small picture does not look long enough at the places to be worth many.
  constexpr size_t EVERY = 4, LEAST = 1024, MOST = 65536, AT_ONCE = 64;
  const size_t pixels = size_t(scene.film().width) * size_t(scene.film().height);
  const size_t every = std::max(EVERY, first.size() / std::clamp(4 * pixels, LEAST, MOST));
  const size_t ofPhotons = (first.size() + every - 1) / every;
  places.assign(ofPhotons + (first.empty() ? 0 : seen.size()), {});
  std::vector<Photon> lifted(places.size());
  const size_t parts = (places.size() + AT_ONCE - 1) / AT_ONCE;
  std::vector<TransportCounts> partCounts(parts);
  parallelFor(parts, [&](size_t part) {
    PhotonScratch scratch;
    for (size_t i = part * AT_ONCE; i < std::min(places.size(), (part + 1) * AT_ONCE); ++i) {
      GatherRegion region;
      const auto radius = [&] {
        region.radius = limit;
        if (nearest == 0) return limit;
        const NearestPhotons n = first.nearest(region, nearest, scratch);
        return n.count == nearest ? std::sqrt(n.radius2) : limit;
      };
      SurfacePoint point;
      if (i < ofPhotons) {
        Photon& photon = lifted[i];
        photon.position = region.center = first.position(i * every);
        photon.direction = first.packedDirection(i * every);
        region.bothSides = true;
        if (!surfaceOf(scene, photon, radius(), point, partCounts[part])) continue;
        region.bothSides = false;
      } else {
        point = seen[i - ofPhotons];
      }
      region.center = point.position;
      region.normal = point.geometricNormal;
      region.flatness = flatness;
      Place& place = places[i];
      const float error = glm::length(point.error);
      Surroundings surroundings{scene, Sampler(0, 0, static_cast<uint32_t>(i))};
      // What is known of the surface changes the radius, and with the radius what has to be known.
      constexpr float BEYOND = 2.5f, ENOUGH = 1.5f; // searches near the place may need more than itself
      constexpr int ROUNDS = 4;
      region.radius = radius();
      for (int round = 0; round < ROUNDS && ENOUGH * region.radius > place.around.reach; ++round) {
        region.radius *= BEYOND;
        place.around = lookAround(scene, error, region, surroundings.sampler, partCounts[part]);
        surroundings.known = &place.around;
        const auto fit = [&] { fitToSurface(surroundings, error, kernel, region, partCounts[part]); };
        region.radius = radius();
        region.flatness =
            region.radius <= surroundings.flat() ? flatnessOfFlat(surroundings, flatness, error) : flatness;
        fit();
        if (region.clipCount > 0 || region.flatness < flatness) {
          region.radius = radius();
          fit();
        }
      }
      place.position = point.position;
      place.normal = point.geometricNormal;
      place.radius = region.radius;
      lifted[i].position = point.position + lift * point.geometricNormal;
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
