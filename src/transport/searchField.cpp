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

/**
 * How estimates with discs of several areas err at a place, told by the photons of one pass: their variance
 * is the sum of the squares of what each photon brings, and two discs whose estimates differ by more than
 * chance show bias, as in Lepski's choice of a bandwidth ("On a problem of adaptive estimation in Gaussian
 * white noise", 1990). The areas double from one to the next.
 */
struct DiscErrors {
  static constexpr size_t AREAS = 8, OWN = 3; ///< OWN: the area of the place
  std::array<double, AREAS> variance{};       ///< of the photons' number
  std::array<double, AREAS> bias2{}; ///< by how much, squared, the next disc differs beyond what is noise
  double irradiance = 0;             ///< by the own disc

  void add(const DiscErrors& e, double scale) {
    for (size_t j = 0; j < AREAS; ++j) {
      variance[j] += e.variance[j] * scale;
      bias2[j] += e.bias2[j] * scale;
    }
  }
  /** The area with the least variance + biasWeight · bias². The bias of a disc goes with its area, so the
   * next one's is larger by as much as it is itself. */
  size_t best(double biasWeight) const {
    constexpr double SURE = 0.5; // to look at fewer photons takes better evidence than to look at more
    size_t best = OWN;
    double least = double(INFINITE), below = 0;
    const auto error = [&](size_t j) { return variance[j] + biasWeight * std::max(0.0, below + bias2[j]); };
    for (size_t j = OWN; j + 1 < AREAS; ++j) {
      if (const double e = error(j); e < least) {
        least = e;
        best = j;
      }
      // Where an edge is met, the bias does not grow as it does elsewhere, but it stays.
      below += std::max(0.0, bias2[j]);
    }
    below = 0;
    least *= SURE;
    for (size_t j = 0; j < OWN; ++j)
      if (const double e = error(j); e < least) {
        least = e;
        best = j;
      }
    return best;
  }
};

/** The radius of a disc over that of the place. */
float ofArea(size_t j) {
  return std::exp2(0.5f * (static_cast<float>(j) - static_cast<float>(DiscErrors::OWN)));
}

/** `region`: of the place's own radius. */
DiscErrors discErrors(const PhotonMap& photons, GatherRegion region, Kernel kernel, float error,
                      Surroundings& surroundings, TransportCounts& counts) {
  constexpr size_t AREAS = DiscErrors::AREAS;
  const float own = region.radius;
  alignas(32) float inverse[AREAS], norm[AREAS];
  for (size_t j = 0; j < AREAS; ++j) { // the largest comes last: its half-spaces stay
    region.radius = own * ofArea(j);
    const float part = fitToSurface(surroundings, error, kernel, region, counts);
    const float radius2 = square(region.radius);
    inverse[j] = 1 / radius2;
    norm[j] = INV_PI / (radius2 * part);
  }
  Float8 sum(0), variance(0), noise(0);
  const __m256i next = _mm256_setr_epi32(1, 2, 3, 4, 5, 6, 7, 7);
  withKernel(kernel, [&](auto k) {
    photons.visitWithin(region, [&](const PhotonBlock& block) {
      alignas(32) float d2[8];
      block.distance2.store(d2);
      for (uint32_t rest = block.mask; rest != 0; rest &= rest - 1) {
        const int lane = std::countr_zero(rest);
        const Rgb power = block.power(lane);
        const Float8 q = Float8(d2[lane]) * Float8::load(inverse);
        const Float8 inside = less(q, Float8(1));
        const Float8 brings = (kernelShape<decltype(k)::value>(min(q, Float8(1))) & inside) *
                              Float8::load(norm) * Float8(power.r + power.g + power.b);
        const Float8 difference = brings - Float8(_mm256_permutevar8x32_ps(brings.v, next));
        sum += brings;
        variance += brings * brings;
        noise += difference * difference;
      }
    });
  });
  DiscErrors e;
  for (size_t j = 0; j < AREAS; ++j) {
    const int lane = static_cast<int>(j);
    e.variance[j] = double(variance[lane]);
    if (j + 1 < AREAS) e.bias2[j] = square(double(sum[lane]) - double(sum[lane + 1])) - double(noise[lane]);
  }
  e.irradiance = double(sum[int(DiscErrors::OWN)]);
  return e;
}

} // namespace

void SearchField::build(const Scene& scene, const PhotonMap& first, std::span<const SurfacePoint> seen,
                        const GatherSettings& search, double alpha, TransportCounts& counts) {
  limit = search.radius;
  lift = 2 * scene.bounds().radius;
  // A small picture does not look long enough at the places to be worth many.
  constexpr size_t EVERY = 4, LEAST = 1024, MOST = 65536, AT_ONCE = 64;
  const size_t pixels = size_t(scene.film().width) * size_t(scene.film().height);
  const size_t every = std::max(EVERY, first.size() / std::clamp(4 * pixels, LEAST, MOST));
  const size_t ofPhotons = (first.size() + every - 1) / every;
  places.assign(ofPhotons + (first.empty() ? 0 : seen.size()), {});
  std::vector<Photon> lifted(places.size());
  const auto forAll = [&](size_t count, const auto& f) {
    const size_t parts = (count + AT_ONCE - 1) / AT_ONCE;
    std::vector<TransportCounts> partCounts(parts);
    parallelFor(parts, [&](size_t part) {
      PhotonScratch scratch;
      for (size_t i = part * AT_ONCE; i < std::min(count, (part + 1) * AT_ONCE); ++i)
        f(i, scratch, partCounts[part]);
    });
    for (const TransportCounts& c : partCounts) counts.add(c);
  };
  const auto regionAt = [&](const Place& place) {
    GatherRegion region;
    region.center = place.position;
    region.normal = place.normal;
    region.flatness = search.flatness;
    region.radius = place.radius;
    return region;
  };
  const auto surroundingsOf = [&](size_t i) {
    const Neighbourhood& around = places[i].around;
    return Surroundings{scene, Sampler(0, 0, static_cast<uint32_t>(i)), around.reach > 0 ? &around : nullptr};
  };
  const auto flatnessOf = [&](const Place& place, const Surroundings& surroundings, float radius) {
    return radius <= surroundings.flat() ? flatnessOfFlat(surroundings, search.flatness, place.error)
                                         : search.flatness;
  };
  /** Finds how far to look at a place that photons alone would have looked at as far as `radius(region)`. */
  const auto settle = [&](size_t i, const auto& radius, TransportCounts& partCounts) {
    Place& place = places[i];
    GatherRegion region = regionAt(place);
    Surroundings surroundings = surroundingsOf(i);
    // What is known of the surface changes the radius, and with the radius what has to be known.
    constexpr float BEYOND = 2.5f, ENOUGH = 1.5f; // searches near the place may need more than itself
    constexpr int ROUNDS = 4;
    const auto fit = [&] { fitToSurface(surroundings, place.error, search.kernel, region, partCounts); };
    region.radius = radius(region);
    for (int round = 0; round < ROUNDS; ++round) {
      if (ENOUGH * region.radius > place.around.reach) {
        region.radius *= BEYOND;
        place.around = lookAround(scene, place.error, region, surroundings.sampler, partCounts);
        surroundings.known = &place.around;
      } else if (round > 0) {
        break;
      }
      region.radius = radius(region);
      region.flatness = flatnessOf(place, surroundings, region.radius);
      fit();
      if (region.clipCount > 0 || region.flatness < search.flatness) {
        region.radius = radius(region);
        fit();
      }
    }
    place.radius = region.radius;
  };

  forAll(places.size(), [&](size_t i, PhotonScratch& scratch, TransportCounts& partCounts) {
    const auto radius = [&](GatherRegion region) {
      region.radius = limit;
      if (search.nearest == 0) return limit;
      const NearestPhotons n = first.nearest(region, search.nearest, scratch);
      return n.count == search.nearest ? std::sqrt(n.radius2) : limit;
    };
    SurfacePoint point;
    if (i < ofPhotons) {
      Photon& photon = lifted[i];
      GatherRegion region;
      photon.position = region.center = first.position(i * every);
      photon.direction = first.packedDirection(i * every);
      region.bothSides = true;
      if (!surfaceOf(scene, photon, radius(region), point, partCounts)) return;
    } else {
      point = seen[i - ofPhotons];
    }
    places[i].position = point.position;
    places[i].normal = point.geometricNormal;
    places[i].error = glm::length(point.error);
    settle(i, radius, partCounts);
    lifted[i].position = point.position + lift * point.geometricNormal;
  });
  index.build(lifted);
  if (alpha == 0 || search.nearest == 0 || first.empty()) return;

  // Where there are photons enough for less noise, or too few for less blur, the discs become others.
  constexpr size_t MOST_MEASURED = 4096; // of either kind
  std::vector<size_t> judged;
  const auto judgeSome = [&](size_t from, size_t end) {
    const size_t stride = (end - from + MOST_MEASURED - 1) / MOST_MEASURED;
    for (size_t i = from; i < end; i += stride) judged.push_back(i);
  };
  judgeSome(0, ofPhotons);
  judgeSome(ofPhotons, places.size());
  std::vector<Photon> measuredAt(judged.size());
  std::vector<DiscErrors> errors(judged.size());
  forAll(judged.size(), [&](size_t m, PhotonScratch&, TransportCounts& partCounts) {
    const size_t i = judged[m];
    measuredAt[m] = lifted[i];
    if (places[i].radius == 0) return;
    GatherRegion region = regionAt(places[i]);
    Surroundings surroundings = surroundingsOf(i);
    region.flatness = flatnessOf(places[i], surroundings, region.radius * ofArea(DiscErrors::AREAS - 1));
    errors[m] = discErrors(first, region, search.kernel, places[i].error, surroundings, partCounts);
  });
  double mean = 0;
  for (const DiscErrors& e : errors) mean += e.irradiance / static_cast<double>(errors.size());
  PhotonMap measured;
  measured.build(measuredAt);
  // Over P passes whose areas shrink as i^(alpha-1) (Knaus and Zwicker 2011) the mean has P^(alpha-1) / alpha
  // of the first one's bias and P^-alpha / (2 - alpha) of its variance; for alpha = 2/3 both errors have the
  // same order.
  const double biasWeight = (2 - alpha) / square(alpha);
  forAll(places.size(), [&](size_t i, PhotonScratch& scratch, TransportCounts& partCounts) {
    if (places[i].radius == 0) return;
    constexpr int NEAREST = 16; // one place has hardly any evidence
    constexpr double DARK = 0.3;
    GatherRegion region;
    region.center = lifted[i].position;
    region.bothSides = true;
    measured.nearest(region, NEAREST, scratch);
    DiscErrors all;
    measured.visitNearest(scratch, [&](const PhotonBlock& block) {
      for (uint32_t rest = block.mask; rest != 0; rest &= rest - 1) {
        const size_t m = measured.emissionIndex(block.first + static_cast<size_t>(std::countr_zero(rest)));
        if (!places[i].around.sees(places[judged[m]].position)) continue;
        const DiscErrors& e = errors[m];
        if (e.irradiance > 0) all.add(e, 1 / (square(e.irradiance) + square(DARK * mean)));
      }
    });
    if (all.variance[0] == 0) return;
    const size_t best = all.best(biasWeight);
    if (best == DiscErrors::OWN) return;
    const float radius = places[i].radius * ofArea(best);
    settle(
        i, [&](const GatherRegion&) { return radius; }, partCounts);
  });
  limit *= ofArea(DiscErrors::AREAS - 2);
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
