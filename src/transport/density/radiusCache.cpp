/** @file
 * Construction of the radius cache.
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
std::optional<VisiblePoint> surfaceOf(const Scene& scene, const Photon& photon, float near, float time,
                                      TransportCounts& counts) {
  const Vec3f direction = unpackDirection(photon.direction);
  const float start = 0.01f * near;
  Hit hit;
  if (!intersect(scene, {photon.position + direction * start, -direction, 2 * start, time}, hit, counts))
    return {};
  hit.point.geometricNormal = hit.point.normalTowards(direction);
  return VisiblePoint{hit.point, 0, hit.material && (hit.material->lobes() & TRANSMISSION)};
}

using Record = RadiusCache::Record;

/** Irradiance estimate by one shadow ray, summed over channels [W/m²]. */
double directIrradiance(const Scene& scene, const LightSampler& lights, const Record& record,
                        Sampler& sampler, TransportCounts& counts) {
  if (scene.lights().size() == 0) return 0;
  Hit hit;
  SurfacePoint& point = hit.point;
  point.position = record.position;
  point.error = Vec3f(record.error);
  point.time = record.time;
  point.geometricNormal = point.shadingNormal = record.normal;
  const SampledLight choice(scene.lights(), lights, lightSampleContext(lights, point, record.normal),
                            sampler);
  const std::optional<LiSample> light = choice.sampleLi(point);
  if (!light || !(light->pdf > 0)) return 0;
  const float facing = glm::dot(record.normal, light->direction);
  if (facing <= 0 && !record.bothSides) return 0;
  const Rgb free = transmittance(scene, hit, record.normal, *light, Nesting(), panesLeft(-1, 0), counts);
  return double(channelSum(light->radiance * free) * std::abs(facing) /
                (light->pdf * choice.chosen.probability));
}

/** Computes the radii of cache records from the photons of a first map. */
class RecordFitter {
 public:
  /** Copies of the records with a known geometry, and their positions. */
  struct Fitted {
    std::vector<Record> records;
    PhotonMap positions;
  };

  RecordFitter(const Scene& scene, const PhotonMap& first, const GatherSettings& search,
               const RayAlternative& rays, TransportCounts& counts)
      : scene(scene), first(first), search(search), rays(rays), counts(counts) {}

  /** Creates records at every `every`-th photon and at all visible points, with the distance to the k-th
   * photon, not yet fitted to the surface. Records at photons come first; their number is stored in
   * `ofPhotons`. `time`: of the photons. */
  std::vector<Record> find(size_t every, std::span<const VisiblePoint> seen, float time, size_t& ofPhotons) {
    std::vector<Record> records((first.size() + every - 1) / every);
    const size_t tried = records.size();
    records.resize(tried + seen.size());
    forAll(records.size(), [&](size_t i, PhotonScratch& scratch, TransportCounts& taskCounts) {
      std::optional<VisiblePoint> found;
      if (i < tried) {
        Photon photon;
        photon.position = first.position(i * every);
        photon.direction = first.packedDirection(i * every);
        // Of coinciding photons a surface beside them, by rounding errors, would have a radius of that size.
        const float near = kthDistance(around(photon.position), scratch);
        if (near == 0) return;
        found = surfaceOf(scene, photon, near, time, taskCounts);
        // Transmitting surfaces are seen from both sides, whichever side the light is on.
        if (found && found->transmits && i % 2 == 1) found->point.geometricNormal *= -1.0f;
      } else {
        found = seen[i - tried];
      }
      if (!found) return;
      Record& record = records[i];
      record.position = found->point.position;
      record.normal = found->point.geometricNormal;
      record.error = glm::length(found->point.error);
      record.time = found->point.time;
      record.bothSides = found->transmits;
      record.radius = kthDistance(regionAt(record), scratch);
    });
    // Photons that coincide in one point have no density.
    const auto none = [](const Record& record) { return record.radius == 0; };
    ofPhotons =
        tried - static_cast<size_t>(std::count_if(records.begin(), records.begin() + ptrdiff_t(tried), none));
    std::erase_if(records, none);
    return records;
  }

  /** Fits the radii of all records that are not fitted yet to the surfaces around them, in rounds: records
   * take the geometry that is known at records of the rounds before. Calls then(i, fitted, scratch, counts)
   * for each, with the records of the rounds before. */
  template <class Then> void fit(std::vector<Record>& records, const Then& then) {
    for (const size_t every : {64u, 8u, 1u}) {
      const Fitted fitted = fittedOf(records);
      forAll(records.size(), [&](size_t i, PhotonScratch& scratch, TransportCounts& taskCounts) {
        if (i % every != 0 || isFitted(records[i])) return;
        takeSurroundings(records[i], fitted, 1, scratch);
        fitToPhotons(records[i], i, scratch, taskCounts);
        then(i, fitted, scratch, taskCounts);
      });
    }
  }
  void fit(std::vector<Record>& records) {
    fit(records, [](size_t, const Fitted&, PhotonScratch&, TransportCounts&) {});
  }

  /** Fits all radii to the surfaces. The errors of supports are measured at some records; each record has
   * those of its neighbours. `choosesAreas`: each radius becomes that of the area of least error. */
  void judge(std::vector<Record>& records, size_t ofPhotons, double alpha, LightDetail detail,
             bool choosesAreas) {
    const Measured measured = measure(records, ofPhotons);
    const auto setArea = [&](size_t i, const Fitted& fitted, PhotonScratch& scratch,
                             TransportCounts& taskCounts) {
      Record& record = records[i];
      const Evidence evidence = evidenceAt(measured, record, scratch);
      const size_t area = areaOf(evidence, alpha, detail, choosesAreas);
      if (area != SupportErrors::OWN) {
        takeSurroundings(record, fitted, ofArea(area), scratch);
        scaleRadius(record, i, ofArea(area), taskCounts);
      }
      setErrors(record, evidence, area);
    };
    forAll(measured.indices.size(), [&](size_t m, PhotonScratch& scratch, TransportCounts& taskCounts) {
      setArea(measured.indices[m], {}, scratch, taskCounts);
    });
    fit(records, setArea);
  }

 private:
  /** Records at which the errors of supports are measured, before any choice of area. */
  struct Measured : Fitted {
    std::vector<size_t> indices; ///< index of each measured record among all records
    std::vector<SupportErrors> errors;
    double dark2 = 0; ///< squared irradiance that counts as dark
  };

  static bool isFitted(const Record& record) { return record.around.reach > 0; }
  static Fitted fittedOf(const std::vector<Record>& records) {
    Fitted fitted;
    std::copy_if(records.begin(), records.end(), std::back_inserter(fitted.records), isFitted);
    std::vector<Photon> at(fitted.records.size());
    for (size_t i = 0; i < at.size(); ++i) at[i].position = fitted.records[i].position;
    fitted.positions.build(at);
    return fitted;
  }

  /** Fits some of the records, and measures the errors of their supports. */
  Measured measure(std::vector<Record>& records, size_t ofPhotons) {
    constexpr size_t MAX_MEASURED = 2048; // records of each kind
    constexpr double DARK = 0.3;          // over the mean irradiance
    Measured measured;
    std::vector<size_t>& indices = measured.indices;
    const auto measureSome = [&](size_t from, size_t end) {
      const size_t stride = (end - from + MAX_MEASURED - 1) / MAX_MEASURED;
      for (size_t i = from; i < end; i += stride) indices.push_back(i);
    };
    measureSome(0, ofPhotons);
    measureSome(ofPhotons, records.size());
    const size_t count = indices.size();
    measured.errors.resize(count);
    forAll(count, [&](size_t m, PhotonScratch& scratch, TransportCounts& taskCounts) {
      const size_t i = indices[m];
      Record& record = records[i];
      fitToPhotons(record, i, scratch, taskCounts);
      SupportErrors& errors = measured.errors[m];
      GatherRegion region = regionAt(record);
      BoundaryCorrection boundary = surroundingsOf(record, i);
      region.flatness = flatnessOf(record, boundary, region.radius * ofArea(SupportErrors::AREAS - 1));
      errors = supportErrors(first, region, search.kernel, record.error, boundary, rays, taskCounts);
      if (rays.lights) addDirect(record, i, errors, taskCounts);
    });
    double mean = 0;
    for (const SupportErrors& e : measured.errors) mean += e.irradiance / static_cast<double>(count);
    measured.dark2 = square(DARK * mean);
    static_cast<Fitted&>(measured) = fittedOf(records);
    return measured;
  }

  static GatherRegion around(const Vec3f& position) { return {.center = position, .bothSides = true}; }
  /** Calls f(index) for each position of a block. */
  template <class F>
  static void forIndices(const PhotonMap& positions, const PhotonBlock& block, const F& f) {
    for (uint32_t slots = block.mask; slots != 0; slots &= slots - 1)
      f(positions.emissionIndex(block.first + static_cast<size_t>(std::countr_zero(slots))));
  }
  /** Calls f(index) for the 16 positions nearest to a point. */
  template <class F>
  static void forNearest(const PhotonMap& positions, const Vec3f& point, PhotonScratch& scratch, const F& f) {
    constexpr int NEAREST = 16;
    positions.nearest(around(point), NEAREST, scratch);
    positions.visitNearest(scratch, [&](const PhotonBlock& block) { forIndices(positions, block, f); });
  }

  /** Evidence of neighbouring records. A single record has too little, and neighbours share photons. The more
   * unequal their powers, the larger the neighbourhood: it has the evidence of PHOTONS equal photons. */
  static Evidence evidenceAt(const Measured& measured, const Record& record, PhotonScratch& scratch) {
    constexpr float PHOTONS = 8;
    constexpr float COHERENT = 0.7f;
    constexpr float MAX_RATIO = 4; // ratio of radii: small pools of light say nothing on wide supports
    Evidence evidence;
    const auto add = [&](size_t m, bool onlySeen) {
      const Record& other = measured.records[m];
      const auto [narrow, wide] = std::minmax(record.radius, other.radius);
      if (!(wide < MAX_RATIO * narrow)) return;
      const bool seen =
          glm::dot(record.normal, other.normal) > COHERENT && record.around.sees(other.position);
      if (seen || !onlySeen) evidence.add(measured.errors[m], measured.dark2);
    };
    for (const bool onlySeen : {true, false})
      if (evidence.recordCount == 0)
        forNearest(measured.positions, record.position, scratch, [&](size_t m) { add(m, onlySeen); });
    if (evidence.recordCount == 0) return evidence;
    const Evidence nearest = std::exchange(evidence, {});
    GatherRegion region = around(record.position);
    region.radius = record.radius * std::sqrt(PHOTONS * static_cast<float>(nearest.relativeVariance()));
    measured.positions.visitWithin(region, [&](const PhotonBlock& block) {
      forIndices(measured.positions, block, [&](size_t m) { add(m, true); });
    });
    return evidence.recordCount < nearest.recordCount ? nearest : evidence;
  }

  /** Index of the support with the least expected error over many passes. */
  static size_t areaOf(const Evidence& evidence, double alpha, LightDetail detail, bool choosesAreas) {
    return choosesAreas && evidence.recordCount > 0 ? evidence.relative.best(biasWeightOf(alpha), detail)
                                                    : size_t{SupportErrors::OWN};
  }
  /** Weight of bias² against variance. Over P passes whose areas shrink as i^(alpha-1) (Knaus and Zwicker
   * 2011), the mean has P^(alpha-1) / alpha of the first pass's bias and P^-alpha / (2 - alpha) of its
   * variance; for alpha = 2/3 both errors have the same order. */
  static double biasWeightOf(double alpha) { return (2 - alpha) / square(alpha); }

  void setErrors(Record& record, const Evidence& evidence, size_t area) const {
    const int count = evidence.recordCount;
    if (count == 0) return;
    const SupportErrors& errors = evidence.absolute;
    const double irradiance = errors.irradiance / count;
    record.irradiance = static_cast<float>(irradiance);
    record.variance = static_cast<float>(errors.variance[area] / count);
    if (!rays.lights) return;
    record.raysVariance = static_cast<float>(std::max(0.0, errors.rays2[area] / count - square(irradiance)));
    record.lit = static_cast<float>(irradiance + errors.direct / count);
  }

  /** Copies the geometry around a fitted record on the same surface, if a record with `scale` times the
   * radius needs more than it knows, and the surface is known to be flat that far with nothing close above.
   */
  static void takeSurroundings(Record& record, const Fitted& fitted, float scale, PhotonScratch& scratch) {
    const float needed = ENOUGH * scale * record.radius;
    if (record.around.reach >= needed || fitted.records.empty()) return;
    const Record* best = nullptr;
    float flat = needed;
    forNearest(fitted.positions, record.position, scratch, [&](size_t f) {
      const Record& other = fitted.records[f];
      const float here = other.around.flat - glm::distance(record.position, other.position);
      if (here < flat || other.around.clearance < INFINITE ||
          !other.isOnSurfaceOf(record.position, record.normal))
        return;
      best = &other;
      flat = here;
    });
    if (!best) return;
    record.around = best->around;
    const float away = best->around.flat - flat;
    record.around.reach -= away;
    record.around.flat -= away;
  }

  /** Calls f(i, scratch, counts) in parallel for 0 <= i < count. */
  template <class F> void forAll(size_t count, const F& f) {
    constexpr size_t AT_ONCE = 64;
    const size_t tasks = (count + AT_ONCE - 1) / AT_ONCE;
    std::vector<TransportCounts> taskCounts(tasks);
    parallelFor(tasks, [&](size_t task) {
      PhotonScratch scratch;
      for (size_t i = task * AT_ONCE; i < std::min(count, (task + 1) * AT_ONCE); ++i)
        f(i, scratch, taskCounts[task]);
    });
    for (const TransportCounts& c : taskCounts) counts.add(c);
  }

  void addDirect(const Record& record, size_t key, SupportErrors& e, TransportCounts& taskCounts) const {
    constexpr int SAMPLES = 4;
    Sampler sampler(1, 0, static_cast<uint32_t>(key));
    for (int i = 0; i < SAMPLES; ++i)
      e.direct += directIrradiance(scene, *rays.lights, record, sampler, taskCounts) / SAMPLES;
  }

  float kthDistance(GatherRegion region, PhotonScratch& scratch) const {
    region.radius = search.radius;
    if (search.nearest == 0) return region.radius;
    const NearestPhotons n = first.nearest(region, search.nearest, scratch);
    return n.count == search.nearest ? std::sqrt(n.radius2) : region.radius;
  }

  GatherRegion regionAt(const Record& record) const {
    return {record.position, record.normal, record.radius, search.flatness, record.bothSides, record.time};
  }
  BoundaryCorrection surroundingsOf(const Record& record, size_t key) const {
    const Neighbourhood& around = record.around;
    return {scene, Sampler(0, 0, static_cast<uint32_t>(key)), around.reach > 0 ? &around : nullptr};
  }
  float flatnessOf(const Record& record, const BoundaryCorrection& boundary, float radius) const {
    return radius <= boundary.flat() ? flatnessOfFlat(boundary, search.flatness, record.error, radius)
                                     : search.flatness;
  }

  /** Fits the radius of a record to the distance to the k-th photon on its surface, reduced where too little
   * surface is within. */
  void fitToPhotons(Record& record, size_t key, PhotonScratch& scratch, TransportCounts& taskCounts) const {
    settle(
        record, key, [&](const GatherRegion& region) { return kthDistance(region, scratch); }, taskCounts);
  }
  /** Scales the radius of a fitted record, and reduces it where too little surface is within. */
  void scaleRadius(Record& record, size_t key, float scale, TransportCounts& taskCounts) const {
    record.radius *= scale;
    settle(
        record, key, [radius = record.radius](const GatherRegion&) { return radius; }, taskCounts);
  }

  template <class Radius>
  void settle(Record& record, size_t key, const Radius& radius, TransportCounts& taskCounts) const {
    GatherRegion region = regionAt(record);
    BoundaryCorrection boundary = surroundingsOf(record, key);
    // The surface geometry changes the radius, and the radius determines how much geometry is needed.
    constexpr float BEYOND = 2.5f; // over the radius
    constexpr int ROUNDS = 4;
    const auto cover = [&] { coveredFraction(boundary, record.error, search.kernel, region, taskCounts); };
    for (int round = 0; round < ROUNDS; ++round) {
      if (ENOUGH * region.radius > record.around.reach) {
        region.radius *= BEYOND;
        record.around = probeNeighbourhood(scene, record.error, region, boundary.sampler, taskCounts);
        boundary.known = &record.around;
      } else if (round > 0) {
        break;
      }
      region.radius = radius(region);
      region.flatness = flatnessOf(record, boundary, region.radius);
      cover();
      if (region.clipCount > 0 || region.flatness < search.flatness) {
        region.radius = radius(region);
        cover();
      }
    }
    record.radius = region.radius;
  }

  static constexpr float ENOUGH = 1.5f; ///< over the radius: gathers near the record may reach farther

  const Scene& scene;
  const PhotonMap& first;
  const GatherSettings& search;
  const RayAlternative& rays;
  TransportCounts& counts;
};

/** Median of the radii; 0 without records. */
float medianRadius(const std::vector<Record>& records) {
  if (records.empty()) return 0;
  std::vector<float> radii(records.size());
  std::ranges::transform(records, radii.begin(), &Record::radius);
  const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
  std::ranges::nth_element(radii, middle);
  return *middle;
}

} // namespace

void RadiusCache::build(const Scene& scene, const PhotonMap& first, float time,
                        std::span<const VisiblePoint> seen, const GatherSettings& search, double alpha,
                        LightDetail detail, const RayAlternative& rays, TransportCounts& counts,
                        bool choosesAreas) {
  limit = search.radius;
  records.clear();
  // The number of records is limited by the pixels, since a small image has less use for each.
  constexpr size_t EVERY = 4, MIN_COUNT = 8192, MAX_COUNT = 65536;
  const size_t pixels = size_t(scene.film().width) * size_t(scene.film().height);
  RecordFitter finder(scene, first, search, rays, counts);
  size_t ofPhotons = 0;
  if (!first.empty())
    records = finder.find(std::max(EVERY, first.size() / std::clamp(pixels / 4, MIN_COUNT, MAX_COUNT)), seen,
                          time, ofPhotons);
  if (alpha > 0 && search.nearest > 0 && !records.empty()) {
    finder.judge(records, ofPhotons, alpha, detail, choosesAreas);
    if (choosesAreas) limit *= ofArea(SupportErrors::AREAS - 2);
  } else {
    finder.fit(records);
  }
  lift = std::min(medianRadius(records), 2 * scene.bounds().radius);
  std::vector<Photon> lifted(records.size());
  for (size_t i = 0; i < records.size(); ++i)
    lifted[i].position = regionInIndex(records[i].position, records[i].normal).center;
  index.build(lifted);
  std::vector<Record> inOrder(records.size());
  for (size_t slot = 0; slot < index.size(); ++slot) inOrder[slot] = records[index.emissionIndex(slot)];
  records = std::move(inOrder);
  findNeighbours();
}

} // namespace recurse
