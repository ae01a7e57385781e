/** @file
 * Shooting and indexing of photons, and learning in the first pass.
 */
#include "integrators/photonmap/photonPass.h"

#include <cfloat>
#include <chrono>

#include "recurse/core/io/text.h"
#include "recurse/core/threads/processorTime.h"
#include "transport/paths/mediumFlight.h"
#include "transport/weights/mergeWeights.h"

namespace recurse {

namespace {

/** Lengths of photons in the order of a stable partition: caustic photons first. */
std::vector<float> causticsFirst(const std::vector<Photon>& photons, const std::vector<float>& lengths) {
  std::vector<float> ordered;
  if (lengths.empty()) return ordered;
  ordered.reserve(lengths.size());
  for (const bool isCaustic : {true, false})
    for (size_t i = 0; i < photons.size(); ++i)
      if (photons[i].caustic == isCaustic) ordered.push_back(lengths[i]);
  return ordered;
}

// A single map must suffice for the whole image. Of progressive maps the mean must, and many must come soon.
constexpr uint64_t ONE_MAP_PHOTONS = 1000000, MIN_PROGRESSIVE_PHOTONS = 65536,
                   MAX_PROGRESSIVE_PHOTONS = 262144;

} // namespace

uint64_t PhotonPass::photonCount(const Scene& scene, bool progressive) const {
  if (settings.photons > 0) return settings.photons;
  if (!progressive) return ONE_MAP_PHOTONS;
  const FilmSettings& film = scene.film();
  return std::clamp(uint64_t(film.width) * uint64_t(film.height), MIN_PROGRESSIVE_PHOTONS,
                    MAX_PROGRESSIVE_PHOTONS);
}

ForwardStatistics PhotonPass::run(const Scene& scene, const PathClasses& classes, const Pass& pass,
                                  const ForwardControl& control, const LightSampler& shadowRays) {
  ForwardStatistics statistics;
  double& learning = statistics.learningSeconds;
  progressive = pass.schedule != PassSchedule::ONE_MAP;
  radiusOverFirst = radiusScale(pass.index, settings.alpha);
  if (pass.index > 0 && inVain) return statistics;
  auto start = std::chrono::steady_clock::now();
  ShootSettings shoot;
  shoot.photons = photonCount(scene, progressive);
  shoot.maxDepth = settings.maxDepth;
  // The arrival density of photons is unknown behind media.
  if (!settings.directLight && !scene.hasMedia()) shoot.shadowRays = &shadowRays;
  shoot.direct = settings.directLight;
  shoot.causticsOnly = settings.causticsOnly;
  if (scene.hasMedia()) {
    if (pass.index == 0) learnOutsideMedium(scene, statistics);
  }
  shoot.emission = emission();
  if (scene.hasMedia() && !settings.causticsOnly) {
    if (pass.index == 0) {
      const ProcessorTimer timer(learning);
      if (!emissiveMedia.learn(scene, outside, pass.seed, pass.time, statistics.counts))
        statistics.warnings.push_back("no photon found a path from the glowing medium: it lights nothing");
    }
    shoot.emission.media = &emissiveMedia;
  }
  if (pass.index == 0) {
    guidance = {};
    portals = {};
    aim = {};
    const ProcessorTimer timer(learning);
    if (settings.guided && scene.lights().size() > 0)
      learnGuidance(scene, classes, pass.seed, shoot, control, statistics);
  }
  shoot.region = &region;
  shoot.splitPower = guidance.splitPower / static_cast<float>(shoot.photons);
  if (scene.hasMedia() && !settings.causticsOnly) {
    if (pass.index == 0) {
      const ProcessorTimer timer(learning);
      learnMedia(scene, classes, pass, shoot, control, statistics);
    }
    shoot.inMedia = media;
  }
  shoot.lightPaths = control.lightPaths;
  ShotPhotons shot = shootPhotons(scene, classes, pass, shoot, control);
  statistics.counts.add(shot.counts);
  emitted = shot.emitted;
  statistics.photonsEmitted = shot.emittedHere;
  statistics.photonsStored = shot.storedHere;
  statistics.shootSeconds = secondsSince(start);

  start = std::chrono::steady_clock::now();
  const std::vector<float> lengths = causticsFirst(shot.stored, shot.lengths.onSurfaces);
  const auto firstIndirect = std::stable_partition(shot.stored.begin(), shot.stored.end(),
                                                   [](const Photon& p) { return p.caustic; });
  causticLayer.map.build({shot.stored.begin(), firstIndirect}, settings.index);
  indirectLayer.map.build({firstIndirect, shot.stored.end()}, settings.index);
  if (!lengths.empty()) {
    const auto caustics = static_cast<size_t>(firstIndirect - shot.stored.begin());
    causticLayer.map.setLengths(std::span(lengths).first(caustics));
    indirectLayer.map.setLengths(std::span(lengths).subspan(caustics));
  }
  constexpr float WIDEST = 0.05f;       // maximum radius relative to the scene's; wider hides all detail
  constexpr float ONE_DIMENSION = 1.2f; // ratio of the optimal rates 1/5 (blur in one dimension) and 1/6
  const float widest = WIDEST * scene.bounds().radius;
  mediaPhotons.points.build(std::move(shot.inMedia), radiusOverFirst, widest, shot.lengths.inMedia);
  mediaPhotons.beams.build(std::move(shot.beams), std::pow(radiusOverFirst, ONE_DIMENSION), widest,
                           std::move(shot.lengths.beams));
  if (settings.edges) mediaPhotons.points.findBounds(scene, pass.time, statistics.counts);
  statistics.photonsRefused = causticLayer.map.refused() + indirectLayer.map.refused();
  statistics.balanceSeconds = secondsSince(start);
  statistics.mapBytes =
      causticLayer.map.memoryBytes() + indirectLayer.map.memoryBytes() + mediaPhotons.memoryBytes();
  if (pass.index == 0) {
    const ProcessorTimer timer(learning);
    learnRadii(scene, classes, shadowRays, statistics);
  }
  return statistics;
}

void PhotonPass::learnFrom(const PhotonPass& other) {
  causticLayer.choice = other.causticLayer.choice;
  causticLayer.radii = other.causticLayer.radii;
  causticChances = other.causticChances;
  portals = other.portals;
  aim = other.aim;
  lights = other.lights;
  guidance = other.guidance;
  region = other.region;
  outside = other.outside;
  outsideTransmittance = other.outsideTransmittance;
  progressive = other.progressive;
  causticsKnown = other.causticsKnown;
}

ForwardStatistics PhotonPass::with(const Pass& other, const Scene& scene, const PathClasses& classes,
                                   const ForwardControl& control, const LightSampler& shadowRays,
                                   const std::function<void()>& use) {
  PhotonMap caustics = std::move(causticLayer.map), indirect = std::move(indirectLayer.map);
  MediaPhotons inMedia = std::move(mediaPhotons);
  const float scale = radiusOverFirst;
  ForwardControl unrecorded = control;
  unrecorded.lightPaths = nullptr;
  const ForwardStatistics statistics = run(scene, classes, other, unrecorded, shadowRays);
  use();
  causticLayer.map = std::move(caustics);
  indirectLayer.map = std::move(indirect);
  mediaPhotons = std::move(inMedia);
  radiusOverFirst = scale;
  return statistics;
}

void PhotonPass::learnOutsideMedium(const Scene& scene, ForwardStatistics& statistics) {
  outside = mediumOutside(scene, statistics.counts);
  const Medium* around = scene.medium(outside);
  outsideTransmittance = Rgb(1);
  if (around && around->isHomogeneous())
    outsideTransmittance = flight::transmittance(around->at(Vec3f(0)).extinction(), INFINITE);
  bool isLitFromFar = false;
  for (size_t i = 0; i < scene.lights().size(); ++i)
    isLitFromFar = isLitFromFar || scene.lights()[i].isInfinite();
  if (isLitFromFar && isBlack(outsideTransmittance))
    statistics.warnings.push_back(
        "the medium around the scene is infinite: it absorbs all light of infinite and distant lights. "
        "Enclose the medium in a shape with the material \"interface\"");
}

namespace {

/** Whether a medium stores beams on request. Beams need the closed forms of homogeneous media, and are
 * unsuitable if most of them are nearly parallel to the directions that they scatter into. */
bool keepsBeams(const Medium& medium) {
  constexpr float NEEDLE = 0.9f; // maximum absolute mean cosine of the phase function
  return medium.isHomogeneous() && thinnest(medium.at(Vec3f(0)).extinction()) > 0 &&
         std::abs(medium.phase->meanCosine()) < NEEDLE;
}

} // namespace

void PhotonPass::learnMedia(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            ShootSettings shoot, const ForwardControl& control,
                            ForwardStatistics& statistics) {
  constexpr uint64_t TRIALS = 4096;
  // Maximum points and beams stored for each emitted photon. Photons scatter hundreds of times in thick
  // media, and a ray passes a hundred times as many beams as points.
  constexpr double POINTS = 4, BEAMS = 0.25;
  const auto partOf = [](double wanted, size_t stored) {
    return static_cast<float>(std::min(1.0, wanted * double(TRIALS) / double(std::max<size_t>(1, stored))));
  };
  media = {};
  media.byBeams.assign(scene.mediumCount() + 1u, false);
  for (uint16_t i = 1; i <= scene.mediumCount(); ++i)
    media.byBeams[i] = settings.beams && keepsBeams(*scene.medium(i));
  shoot.photons = TRIALS;
  shoot.inMedia = media;
  Pass trial = pass;
  trial.seed = hashCombine(pass.seed, TRIALS);
  const ShotPhotons shot = shootPhotons(scene, classes, trial, shoot, control);
  statistics.counts.add(shot.counts);
  media.pointPart = partOf(POINTS, shot.inMedia.size());
  media.beamPart = partOf(BEAMS, shot.beams.size());
}

void PhotonPass::learnRadii(const Scene& scene, const PathClasses& classes, const LightSampler& shadowRays,
                            ForwardStatistics& statistics) {
  const float counted = static_cast<float>(emitted) * static_cast<float>(guidance.emission.gain());
  const LightSampler* sampled = settings.directLight || scene.lights().size() == 0 ? nullptr : &shadowRays;
  // Arrival densities are unknown for photons that media scatter, but known for caustics.
  const RayAlternative toIndirect{counted, scene.hasMedia() ? nullptr : sampled};
  constexpr float FIREFLY = 1e6f; // relative value that about one sample of an image exceeds
  const RayAlternative toCaustics{counted, sampled, FIREFLY};
  const GatherSettings requested{
      settings.kernel, settings.nearest, static_cast<float>(settings.radius), settings.flatness, {}};
  const auto seen = probeCamera(scene, 24, 0, settings.weighting, statistics.counts);
  // Records at visible points cover dark regions, which have few photons.
  const double across = std::sqrt(double(scene.film().whole().area())) / 4;
  const auto manySeen = probeCamera(scene, static_cast<int>(std::clamp(across, 4.0, 128.0)), 2,
                                    settings.weighting, statistics.counts);
  constexpr size_t MIN_CAUSTIC = 16; // minimum number of caustic photons; fewer are strong spots
  const bool judged = progressive && settings.nearest == 0 && settings.radius == 0;
  const size_t stored = causticLayer.map.size() + indirectLayer.map.size();
  tooFew = stored * MIN_STORED < emitted || stored < MIN_MAP;
  inVain = manySeen.empty() && stored + mediaPhotons.size() == 0;
  const bool areAllWanted = classes.lightStateCount() == 1; // else possibly none, e.g. for class LDE
  if (tooFew && areAllWanted && emitted > 0 && mediaPhotons.size() == 0 && scene.lights().size() > 0)
    statistics.warnings.push_back(
        formatted("only %zu of %llu photons (%.3g %%) were stored on surfaces: paths sample indirect light "
                  "instead, and caustics of small lights are noisy. Emit more photons (--photons), and check "
                  "that the lights are inside of the scene and do not point away",
                  stored, static_cast<unsigned long long>(emitted), 100 * double(stored) / double(emitted)));
  for (PhotonLayer* layer : {&indirectLayer, &causticLayer}) {
    ForwardStatistics discarded;
    const bool isCaustic = layer == &causticLayer;
    // With photons of direct light the layer also contains shadows.
    const LightDetail detail = isCaustic && !settings.directLight ? LightDetail::FINE : LightDetail::SMOOTH;
    layer->choice = chooseGather(scene, layer->map, seen, requested, progressive, settings.directLight,
                                 detail, isCaustic ? discarded : statistics);
    if (!progressive && !settings.edges) continue;
    auto radii = std::make_shared<RadiusCache>();
    radii->build(scene, layer->map, manySeen, layer->choice.settings, judged ? settings.alpha : 0, detail,
                 isCaustic ? toCaustics : toIndirect, statistics.counts,
                 settings.without != Mechanism::JUDGED_RADII);
    layer->radii = std::move(radii);
  }
  causticsKnown = causticLayer.map.size() >= MIN_CAUSTIC;
  causticChances.clear();
  if (judged) learnChances();
  causticRays = judged ? causticVarianceAt(manySeen) : 0;
}

void PhotonPass::learnChances() {
  constexpr double PART = 0.1;  // of caustics and direct light: brighter caustics are always estimated
  constexpr float LEAST = 0.1f; // records with few photons may not know of a caustic near by
  const RadiusCache& cache = causticLayer.cache();
  causticChances.assign(cache.size(), LEAST);
  for (size_t i = 0; i < cache.size(); ++i) {
    const RadiusCache::Record& record = cache.record(i);
    const double all = std::max(double(record.worth.irradiance), double(record.irradiance));
    if (all > 0)
      causticChances[i] =
          static_cast<float>(std::clamp(double(record.irradiance) / (PART * all), double(LEAST), 1.0));
  }
}

double PhotonPass::causticVarianceAt(std::span<const VisiblePoint> seen) const {
  double sum = 0;
  for (const VisiblePoint& visible : seen) {
    const auto at = [&](const PhotonLayer& layer) {
      const CachedRadius near = layer.cache().at(visible.point.position, visible.point.geometricNormal);
      return near.known ? &layer.cache().record(near.index) : nullptr;
    };
    const RadiusCache::Record *caustic = at(causticLayer), *other = at(indirectLayer);
    if (!caustic || !(caustic->worth.raysVariance > 0)) continue;
    const double all = double(caustic->worth.irradiance) + (other ? double(other->irradiance) : 0);
    sum += double(caustic->worth.raysVariance) / square(all);
  }
  return seen.empty() ? 0 : sum / double(seen.size());
}

namespace {

/** Processor time of a search, relative to a camera path with a few surfaces. */
float searchCost(const PhotonQuery& query, LobeSet lobes) {
  constexpr float PHOTONS = 0.1f;    ///< summation of photons, eight at a time
  constexpr float SCATTERING = 0.6f; ///< evaluation of each photon by a BSDF that is not Lambertian
  constexpr float AROUND = 0.8f;     ///< rays that search for the edges of the surface
  const CachedRadius& cached = query.cached;
  const bool isFlat = cached.known && query.settings.radius <= cached.known->flat - cached.away;
  return PHOTONS + (lobes & LAMBERTIAN ? 0 : SCATTERING) + (isFlat ? 0 : AROUND);
}

} // namespace

PhotonQuery PhotonPass::query(const PhotonLayer& layer, const SurfacePoint& point, const Vec3f& wi,
                              LobeSet lobes) const {
  PhotonQuery here{layer.choice.settings, {}};
  if (progressive || settings.edges) here.cached = layer.cache().at(point.position, point.normalTowards(wi));
  if (progressive) here.settings = searchWithin(layer, here.cached.radius);
  here.cost = searchCost(here, lobes);
  if (&layer == &causticLayer && !settings.directLight) {
    here.settings.weighedAgainstRays = true;
    here.settings.merging =
        causticsKnown ? static_cast<float>(emitted) * static_cast<float>(guidance.emission.gain()) : 0;
    constexpr float ALL_TO_PHOTONS = 1e15f;
    if (settings.without == Mechanism::MERGE_WEIGHTS) here.settings.merging = ALL_TO_PHOTONS;
    if (!causticChances.empty()) here.settings.chance = causticChances[here.cached.index];
  } else {
    here.settings.weighting = settings.weighting;
  }
  return here;
}

void PhotonPass::weighAgainstRays(PhotonQuery& query, float footprint) const {
  // All pixels of a kernel support share the error of the map, so it averages out less than independent
  // errors of pixels: a strong one is visible as a stain, and counts as a larger variance.
  constexpr double VISIBLE_STAIN = 0.1; // relative variance in the first pass; after about 50, 5 % of error
  /** Squared relative error of a covered fraction that eight rays estimate, which no pass reduces; scaled to
   * the variance of one of 32 passes. */
  constexpr double UNSURE_FRACTION = 0.01 * 32;
  GatherSettings& gather = query.settings;
  gather.weighedAgainstRays = true;
  gather.merging = gather.unknownWeight = 0;
  if (tooFew || indirectLayer.cache().size() == 0) return;
  // Without a record of similar normal, as on strongly curved surfaces, the nearest record is used.
  const RadiusCache::Record& record = indirectLayer.cache().record(query.cached.index);
  const auto variance = double(record.variance), squared = square(double(record.irradiance));
  if (!std::isfinite(variance) || !(variance > 0 && squared > 0)) return;
  const double pixels =
      std::max(1.0, M_PI * square(double(gather.radius) / double(std::max(footprint, FLT_MIN))));
  const double stain = 1 + (std::sqrt(pixels) - 1) * std::min(1.0, variance / squared / VISIBLE_STAIN);
  GatherErrors& errors = gather.errors;
  errors.variance = stain * variance;
  errors.bias2 = double(record.bias2);
  if (!query.cached.known || record.radius > record.around.flat) errors.bias2 += UNSURE_FRACTION * squared;
  gather.merging = static_cast<float>(double(emitted) * guidance.emission.gain() * variance /
                                      (errors.variance + errors.bias2));
  // Relative variance of rays where the cache has none, as in scenes with media: most indirect light of a
  // room comes from about a tenth of the directions.
  constexpr double FEW_DIRECTIONS = 10;
  errors.byRays =
      std::isfinite(record.worth.instead) ? double(record.worth.raysVariance) : FEW_DIRECTIONS * squared;
  gather.unknownWeight = errors.photonWeight(1);
  if (settings.without == Mechanism::MERGE_WEIGHTS) gather.weighedAgainstRays = false;
}

EmissionSettings PhotonPass::emission() const {
  EmissionSettings starts;
  if (settings.guided) starts.lights = &lights;
  starts.guide = &guidance.emission;
  starts.portals = &portals;
  starts.aim = &aim;
  starts.outside = outside;
  starts.outsideTransmittance = outsideTransmittance;
  return starts;
}

LePdf PhotonPass::pdfLe(uint32_t index, const Light& light, const LeRay& ray) const {
  return emission().pdfLe(index, light, ray);
}

float PhotonPass::probability(const Scene& scene, uint32_t light) const {
  return emission().table(scene).probability(light);
}

float PhotonPass::rayWeight(const Scene& scene, MergeRatio merge, const Hit& hit,
                            const Vec3f& direction) const {
  merge.arrive(direction, hit.point);
  const LeRay ray{hit.point.position, -direction, hit.point.geometricNormal, hit.primitive, hit.point.time};
  return merge.cameraWeight(pdfLe(hit.lightIndex, *hit.areaLight, ray), probability(scene, hit.lightIndex));
}

float PhotonPass::rayWeight(const Scene& scene, const MergeRatio& merge, size_t environment,
                            const Ray& ray) const {
  const uint32_t index = scene.environmentIndices()[environment];
  const LePdf pdf =
      pdfLe(index, *scene.environment()[environment], {ray.origin, -ray.direction, Vec3f(0), 0});
  return merge.cameraWeight(pdf, probability(scene, index));
}

float PhotonPass::arrivals(const Scene& scene, uint32_t light, const LePdf& pdf, float cosine, float distance,
                           float chosen) const {
  return arrivalDensity(scene.lights()[light].kind(), pdf, distance, cosine, probability(scene, light),
                        chosen);
}

GatherSettings PhotonPass::searchWithin(const PhotonLayer& layer, float firstRadius) const {
  GatherSettings now = layer.choice.settings;
  if (!progressive) return now;
  now.nearest = 0;
  if (layer.choice.settings.nearest > 0) now.radius = firstRadius;
  now.radius *= radiusOverFirst;
  return now;
}

LightTable PhotonPass::lightsByPower(const LightTable& all) const {
  const double open = portals.active() ? std::min(1.0, double(portals.openPart())) : 1;
  std::vector<const Light*> each;
  std::vector<double> powers;
  for (uint32_t i = 0; i < all.size(); ++i) {
    each.push_back(&all[i]);
    powers.push_back(
        double(maxComponent(all[i].power())) *
        (all[i].isInfinite() ? open * double(maxComponent(outsideTransmittance)) : double(aim.powerPart(i))));
  }
  LightTable table;
  table.build(each, powers);
  return table;
}

void PhotonPass::learnStarts(const Scene& scene, const PathClasses& classes, uint64_t seed,
                             const ShootSettings& shoot, const ForwardControl& control,
                             TransportCounts& counts) {
  LightPortals openings;
  if (settings.without != Mechanism::PORTALS) openings.learn(scene, seed, counts);
  PhotonAim farLamps;
  if (settings.without != Mechanism::AIM) farLamps.learn(scene, seed, counts);
  if (!openings.active() && !farLamps.active()) return;
  const auto tryThese = [&] { return tryStarts(scene, classes, seed, shoot, region, counts); };
  StartTrial best = tryThese();
  const auto adoptIfBetter = [&](LightPortals otherPortals, PhotonAim otherAim) {
    constexpr double WORTH_IT = 2;                       // ratio of variances, which trials estimate badly
    constexpr uint64_t FEW_TRIALS = 256, MANY_TIMES = 4; // of about 32,000 trial photons
    if (control.stopped()) return;
    const auto exchange = [&] {
      std::swap(portals, otherPortals);
      std::swap(aim, otherAim);
      lights = lightsByPower(scene.lights());
    };
    exchange();
    const StartTrial with = tryThese();
    // With very few useful photons their second moment is unknown, and their number decides.
    const bool areManyMore =
        best.useful < FEW_TRIALS && with.useful >= MANY_TIMES * std::max<uint64_t>(1, best.useful);
    const bool isBetter = with.secondMoment > 0 && with.secondMoment * WORTH_IT < best.secondMoment;
    if (areManyMore || isBetter)
      best = with;
    else
      exchange();
  };
  if (openings.active()) adoptIfBetter(openings, {});
  if (farLamps.active()) adoptIfBetter(portals, farLamps);
  // A powerful far light without an aim leaves too few photons to judge the portals, so both are tried.
  if (openings.active() && farLamps.active() && !portals.active()) adoptIfBetter(openings, farLamps);
}

void PhotonPass::learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                               const ShootSettings& shoot, const ForwardControl& control,
                               ForwardStatistics& statistics) {
  region = probeRegion(scene, settings.weighting, statistics.counts);
  lights = lightsByPower(scene.lights());
  // A search for the nearest photons of one map needs photons of nearly equal power.
  if (progressive) learnStarts(scene, classes, seed, shoot, control, statistics.counts);
  guidance = recurse::learnGuidance(scene, classes, seed, shoot, region, control, statistics.counts,
                                    settings.without != Mechanism::GUIDE);
  if (settings.without == Mechanism::SPLITTING) guidance.splitPower = INFINITE;
  noteGuidance(statistics.notes);
}

void PhotonPass::noteGuidance(std::vector<std::string>& notes) const {
  if (portals.active())
    notes.push_back(formatted("photons: emission of infinite and distant lights is guided through %zu "
                              "openings that camera paths see",
                              portals.size()));
  if (aim.active())
    notes.push_back(formatted("photons: emission of %zu far lamp%s aimed at surfaces that camera paths hit",
                              aim.lampCount(), aim.lampCount() == 1 ? " is" : "s are"));
  if (guidance.emission.active())
    notes.push_back(formatted("photons: emission is guided to surfaces that the camera sees; the variance of "
                              "a photon is %.3g times smaller",
                              guidance.emission.gain()));
}

} // namespace recurse
