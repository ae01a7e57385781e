/** @file
 * Construction and lookup of the radius cache.
 */
#include "transport/density/radiusCache.h"

#include "recurse/core/threads/parallel.h"
#include "transport/direct/directLight.h"

namespace recurse {

float radiusScale(uint32_t index, double alpha) {
  // Product over i = 1 … index of (i + alpha) / (i + 1), by gamma functions.
  const double n = double(index);
  return static_cast<float>(
      std::exp(0.5 * (std::lgamma(n + 1 + alpha) - std::lgamma(1 + alpha) - std::lgamma(n + 2))));
}

namespace {

/** Finds the surface on which a photon was stored, by a ray along the photon's path that is short compared to
 * `near`; nullopt if the ray hits nothing. */
std::optional<VisiblePoint> surfaceOf(const Scene& scene, const Photon& photon, float near,
                                      TransportCounts& counts) {
  const Vec3f direction = unpackDirection(photon.direction);
  const float start = 0.01f * near;
  Hit hit;
  if (!intersect(scene, {photon.position + direction * start, -direction, 2 * start}, hit, counts)) return {};
  hit.point.geometricNormal = hit.point.normalTowards(direction);
  return VisiblePoint{hit.point, 0, hit.material && (hit.material->lobes() & TRANSMISSION)};
}

using Place = RadiusCache::Place;

/** Irradiance estimate by one shadow ray, summed over channels [W/m²]. */
double directIrradiance(const Scene& scene, const LightSampler& lights, const Place& place, Sampler& sampler,
                        TransportCounts& counts) {
  Hit hit;
  SurfacePoint& point = hit.point;
  point.position = place.position;
  point.error = Vec3f(place.error);
  point.geometricNormal = point.shadingNormal = place.normal;
  const SampledLight choice(scene.lights(), lights, lightSampleContext(lights, point, place.normal), sampler);
  const std::optional<LiSample> light = choice.sampleLi(point);
  if (!light || !(light->pdf > 0)) return 0;
  const float facing = glm::dot(place.normal, light->direction);
  if (facing <= 0 && !place.bothSides) return 0;
  const Transmittance free =
      transmittance(scene, hit, place.normal, *light, Nesting(), panesLeft(-1, 0), counts);
  return double(channelSum(light->radiance * free.value) * std::abs(facing) /
                (light->pdf * choice.chosen.probability));
}

/** Computes the radii of cache records from the photons of a first map. */
class PlaceFinder {
 public:
  PlaceFinder(const Scene& scene, const PhotonMap& first, const GatherSettings& search,
              const RayAlternative& rays, TransportCounts& counts)
      : scene(scene), first(first), search(search), rays(rays), counts(counts) {}

  /** Creates records at every `every`-th photon and at all visible points, with the distance to the k-th
   * photon. Records at photons come first; their number is stored in `ofPhotons`. */
  std::vector<Place> find(size_t every, std::span<const VisiblePoint> seen, size_t& ofPhotons) {
    std::vector<Place> places((first.size() + every - 1) / every);
    const size_t tried = places.size();
    places.resize(tried + seen.size());
    forAll(places.size(), [&](size_t i, PhotonScratch& scratch, TransportCounts& partCounts) {
      std::optional<VisiblePoint> found;
      if (i < tried) {
        Photon photon;
        photon.position = first.position(i * every);
        photon.direction = first.packedDirection(i * every);
        GatherRegion region;
        region.center = photon.position;
        region.bothSides = true;
        found = surfaceOf(scene, photon, kthDistance(region, scratch), partCounts);
        // Transmitting surfaces are seen from both sides, whichever side the light is on.
        if (found && found->transmits && i % 2 == 1) found->point.geometricNormal *= -1.0f;
      } else {
        found = seen[i - tried];
      }
      if (!found) return;
      Place& place = places[i];
      place.position = found->point.position;
      place.normal = found->point.geometricNormal;
      place.error = glm::length(found->point.error);
      place.footprint = found->footprint;
      place.bothSides = found->transmits;
      settle(
          place, i, [&](const GatherRegion& region) { return kthDistance(region, scratch); }, partCounts);
    });
    const auto none = [](const Place& place) { return place.radius == 0; };
    ofPhotons =
        tried - static_cast<size_t>(std::count_if(places.begin(), places.begin() + ptrdiff_t(tried), none));
    std::erase_if(places, none);
    return places;
  }

  /** Computes the errors, and if `choosesAreas` replaces supports where a different area has less error. */
  void judge(std::vector<Place>& places, size_t ofPhotons, double alpha, LightDetail detail,
             bool choosesAreas) {
    const Measured measured = measure(places, ofPhotons);
    // Over P passes whose areas shrink as i^(alpha-1) (Knaus and Zwicker 2011), the mean has P^(alpha-1) /
    // alpha of the first pass's bias and P^-alpha / (2 - alpha) of its variance; for alpha = 2/3 both errors
    // have the same order.
    const double biasWeight = (2 - alpha) / square(alpha);
    forAll(places.size(), [&](size_t i, PhotonScratch& scratch, TransportCounts& partCounts) {
      Place& place = places[i];
      const float radius = place.radius;
      const Evidence evidence = evidenceAt(places, measured, place, scratch);
      if (evidence.places == 0) return;
      const SupportErrors& errors = evidence.absolute;
      const size_t best =
          choosesAreas ? evidence.relative.best(biasWeight, detail) : size_t{SupportErrors::OWN};
      place.irradiance = static_cast<float>(errors.irradiance / evidence.places);
      place.variance = static_cast<float>(errors.variance[best] / evidence.places);
      double bias2 = 0;
      for (size_t j = 0; j < best; ++j) bias2 += errors.sureBias2(j);
      place.bias2 = static_cast<float>(biasWeight * bias2 / evidence.places);
      if (rays.lights) place.worth = worth(errors, best, double(place.bias2), evidence.places);
      if (best == SupportErrors::OWN) return;
      settle(
          place, i, [&](const GatherRegion&) { return radius * ofArea(best); }, partCounts);
    });
  }

 private:
  /** Records at which the errors of supports are measured, by index of measurement. */
  struct Measured {
    std::vector<size_t> places;
    std::vector<SupportErrors> errors;
    std::vector<float> radii; ///< before any choice of area
    PhotonMap positions;
    double dark2 = 0; ///< squared irradiance that counts as dark
  };

  Measured measure(const std::vector<Place>& places, size_t ofPhotons) {
    constexpr size_t MAX_MEASURED = 4096; // records of each kind
    constexpr double DARK = 0.3;          // over the mean irradiance
    Measured measured;
    const auto measureSome = [&](size_t from, size_t end) {
      const size_t stride = (end - from + MAX_MEASURED - 1) / MAX_MEASURED;
      for (size_t i = from; i < end; i += stride) measured.places.push_back(i);
    };
    measureSome(0, ofPhotons);
    measureSome(ofPhotons, places.size());
    const size_t count = measured.places.size();
    std::vector<Photon> at(count);
    measured.errors.resize(count);
    measured.radii.resize(count);
    forAll(count, [&](size_t m, PhotonScratch&, TransportCounts& partCounts) {
      const size_t i = measured.places[m];
      SupportErrors& errors = measured.errors[m];
      at[m].position = places[i].position;
      measured.radii[m] = places[i].radius;
      GatherRegion region = regionAt(places[i]);
      BoundaryCorrection boundary = surroundingsOf(places[i], i);
      region.flatness = flatnessOf(places[i], boundary, region.radius * ofArea(SupportErrors::AREAS - 1));
      errors = supportErrors(first, region, search.kernel, places[i].error, boundary, rays, partCounts);
      if (rays.lights) addDirect(places[i], i, errors, partCounts);
    });
    double mean = 0;
    for (const SupportErrors& e : measured.errors) mean += e.irradiance / static_cast<double>(count);
    measured.dark2 = square(DARK * mean);
    measured.positions.build(at);
    return measured;
  }

  /** Evidence of neighbouring records. A single record has too little, and neighbours share photons. The more
   * unequal their powers, the larger the neighbourhood: it has the evidence of PHOTONS equal photons. */
  static Evidence evidenceAt(const std::vector<Place>& places, const Measured& measured, const Place& place,
                             PhotonScratch& scratch) {
    constexpr int NEAREST = 16;
    constexpr float PHOTONS = 8;
    constexpr float COHERENT = 0.7f;
    constexpr float MAX_RATIO = 4; // ratio of radii: small pools of light say nothing on wide supports
    const PhotonMap& positions = measured.positions;
    GatherRegion region;
    region.center = place.position;
    region.bothSides = true;
    positions.nearest(region, NEAREST, scratch);
    Evidence evidence;
    const auto add = [&](const PhotonBlock& block, bool onlySeen) {
      for (uint32_t rest = block.mask; rest != 0; rest &= rest - 1) {
        const size_t m = positions.emissionIndex(block.first + static_cast<size_t>(std::countr_zero(rest)));
        const Place& other = places[measured.places[m]];
        const float radius = measured.radii[m];
        if (!(std::max(place.radius, radius) < MAX_RATIO * std::min(place.radius, radius))) continue;
        const bool seen =
            glm::dot(place.normal, other.normal) > COHERENT && place.around.sees(other.position);
        if (seen || !onlySeen) evidence.add(measured.errors[m], measured.dark2);
      }
    };
    positions.visitNearest(scratch, [&](const PhotonBlock& block) { add(block, true); });
    if (evidence.places == 0)
      positions.visitNearest(scratch, [&](const PhotonBlock& block) { add(block, false); });
    if (evidence.places == 0) return evidence;
    const Evidence nearest = std::exchange(evidence, {});
    region.radius = place.radius * std::sqrt(PHOTONS * static_cast<float>(nearest.relativeVariance()));
    positions.visitWithin(region, [&](const PhotonBlock& block) { add(block, true); });
    return evidence.places < nearest.places ? nearest : evidence;
  }

  /** Calls f(i, scratch, counts) in parallel for 0 <= i < count. */
  template <class F> void forAll(size_t count, const F& f) {
    constexpr size_t AT_ONCE = 64;
    const size_t parts = (count + AT_ONCE - 1) / AT_ONCE;
    std::vector<TransportCounts> partCounts(parts);
    parallelFor(parts, [&](size_t part) {
      PhotonScratch scratch;
      for (size_t i = part * AT_ONCE; i < std::min(count, (part + 1) * AT_ONCE); ++i)
        f(i, scratch, partCounts[part]);
    });
    for (const TransportCounts& c : partCounts) counts.add(c);
  }

  void addDirect(const Place& place, size_t key, SupportErrors& e, TransportCounts& partCounts) const {
    constexpr int SAMPLES = 4;
    Sampler sampler(1, 0, static_cast<uint32_t>(key));
    for (int i = 0; i < SAMPLES; ++i)
      e.direct += directIrradiance(scene, *rays.lights, place, sampler, partCounts) / SAMPLES;
  }

  /** Gain of a gather over rays, from sums over `evidence` records. */
  static GatherWorth worth(const SupportErrors& sum, size_t best, double bias2, int evidence) {
    const double n = evidence, irradiance2 = square(sum.irradiance / n);
    const double all2 = square((sum.irradiance + sum.direct) / n);
    const double byRays = std::max(0.0, sum.rays2[best] / n - irradiance2);
    const double byPhotons = sum.variance[best] / n + bias2;
    return {static_cast<float>((all2 + byRays) / (all2 + byPhotons)), static_cast<float>(byRays),
            static_cast<float>(std::sqrt(all2))};
  }

  float kthDistance(GatherRegion region, PhotonScratch& scratch) const {
    region.radius = search.radius;
    if (search.nearest == 0) return region.radius;
    const NearestPhotons n = first.nearest(region, search.nearest, scratch);
    return n.count == search.nearest ? std::sqrt(n.radius2) : region.radius;
  }

  GatherRegion regionAt(const Place& place) const {
    GatherRegion region;
    region.center = place.position;
    region.normal = place.normal;
    region.flatness = search.flatness;
    region.radius = place.radius;
    region.bothSides = place.bothSides;
    return region;
  }
  BoundaryCorrection surroundingsOf(const Place& place, size_t key) const {
    const Neighbourhood& around = place.around;
    return {scene, Sampler(0, 0, static_cast<uint32_t>(key)), around.reach > 0 ? &around : nullptr};
  }
  float flatnessOf(const Place& place, const BoundaryCorrection& boundary, float radius) const {
    return radius <= boundary.flat() ? flatnessOfFlat(boundary, search.flatness, place.error, radius)
                                     : search.flatness;
  }

  /** Fits the radius of a record whose radius from photons alone is `radius(region)`. If this is 0, the
   * photons searched for coincide in one point, which has no density: the record gets no radius, and find()
   * drops it. */
  template <class Radius>
  void settle(Place& place, size_t key, const Radius& radius, TransportCounts& partCounts) const {
    GatherRegion region = regionAt(place);
    BoundaryCorrection boundary = surroundingsOf(place, key);
    // The surface geometry changes the radius, and the radius determines how much geometry is needed.
    constexpr float BEYOND = 2.5f, ENOUGH = 1.5f; // gathers near the record may reach farther
    constexpr int ROUNDS = 4;
    const auto fit = [&] { coveredFraction(boundary, place.error, search.kernel, region, partCounts); };
    region.radius = radius(region);
    if (region.radius == 0) return;
    for (int round = 0; round < ROUNDS; ++round) {
      if (ENOUGH * region.radius > place.around.reach) {
        region.radius *= BEYOND;
        place.around = probeNeighbourhood(scene, place.error, region, boundary.sampler, partCounts);
        boundary.known = &place.around;
      } else if (round > 0) {
        break;
      }
      region.radius = radius(region);
      region.flatness = flatnessOf(place, boundary, region.radius);
      fit();
      if (region.clipCount > 0 || region.flatness < search.flatness) {
        region.radius = radius(region);
        fit();
      }
    }
    place.radius = region.radius;
  }

  const Scene& scene;
  const PhotonMap& first;
  const GatherSettings& search;
  const RayAlternative& rays;
  TransportCounts& counts;
};

} // namespace

void RadiusCache::build(const Scene& scene, const PhotonMap& first, std::span<const VisiblePoint> seen,
                        const GatherSettings& search, double alpha, LightDetail detail,
                        const RayAlternative& rays, TransportCounts& counts, bool choosesAreas) {
  limit = search.radius;
  lift = std::min(search.radius, 2 * scene.bounds().radius);
  places.clear();
  // The number of records is limited by the pixels, since a small image has less use for each.
  constexpr size_t EVERY = 4, MIN_COUNT = 1024, MAX_COUNT = 65536;
  const size_t pixels = size_t(scene.film().width) * size_t(scene.film().height);
  PlaceFinder finder(scene, first, search, rays, counts);
  size_t ofPhotons = 0;
  if (!first.empty())
    places = finder.find(std::max(EVERY, first.size() / std::clamp(4 * pixels, MIN_COUNT, MAX_COUNT)), seen,
                         ofPhotons);
  std::vector<Photon> lifted(places.size());
  for (size_t i = 0; i < places.size(); ++i)
    lifted[i].position = regionInIndex(places[i].position, places[i].normal).center;
  if (alpha > 0 && search.nearest > 0 && !places.empty()) {
    finder.judge(places, ofPhotons, alpha, detail, choosesAreas);
    if (choosesAreas) limit *= ofArea(SupportErrors::AREAS - 2);
  }
  index.build(lifted);
  std::vector<Place> inOrder(places.size());
  for (size_t slot = 0; slot < places.size(); ++slot) inOrder[slot] = places[index.emissionIndex(slot)];
  places = std::move(inOrder);
  findNeighbours();
}

} // namespace recurse
