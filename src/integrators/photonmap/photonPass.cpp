/** @file
 * A pass of photons: shooting, indexing, and what the first pass learns of media.
 */
#include "integrators/photonmap/photonPass.h"

#include <chrono>
#include <cmath>

#include "recurse/core/io/text.h"
#include "recurse/core/threads/processorTime.h"
#include "transport/emission/cameraProbe.h"
#include "transport/paths/mediumFlight.h"

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
  const uint64_t count = std::clamp(uint64_t(film.width) * uint64_t(film.height), MIN_PROGRESSIVE_PHOTONS,
                                    MAX_PROGRESSIVE_PHOTONS);
  // The variance by photons is inversely proportional to the stored ones, their time proportional to all.
  // Error times time is the least for a number of all that is proportional to 1/sqrt(stored).
  constexpr double MOST = 4;
  const double stored = guidance.storedPhotons;
  return stored > 0 ? uint64_t(double(count) * std::clamp(1 / std::sqrt(stored), 1.0, MOST)) : count;
}

ForwardStatistics PhotonPass::run(const Scene& scene, const PathClasses& classes, const Pass& pass,
                                  const ForwardControl& control, const LightSampler& shadowRays) {
  ForwardStatistics statistics;
  progressive = pass.schedule != PassSchedule::ONE_MAP;
  radiusOverFirst = radiusScale(pass.index, settings.alpha);
  if (pass.index > 0 && skipsEmission) return statistics;
  const auto start = std::chrono::steady_clock::now();
  if (pass.index == 0) learnStarts(scene, classes, pass, control, shadowRays, statistics);
  ShootSettings shoot = shootSettings(scene, shadowRays);
  shoot.lightPaths = control.lightPaths;
  ShotPhotons shot = shootPhotons(scene, classes, pass, shoot, control);
  statistics.counts.add(shot.counts);
  emitted = shot.emitted;
  statistics.photonsEmitted = shot.emittedHere;
  statistics.photonsStored = shot.storedHere;
  statistics.shootSeconds = secondsSince(start);
  buildMaps(scene, pass, std::move(shot), statistics);
  if (pass.index == 0) {
    const ProcessorTimer timer(statistics.learningSeconds);
    learnRadii(scene, classes, shadowRays, pass.time, statistics);
  }
  return statistics;
}

ShootSettings PhotonPass::shootSettings(const Scene& scene, const LightSampler& shadowRays) const {
  ShootSettings shoot;
  shoot.photons = photonCount(scene, progressive);
  shoot.maxDepth = settings.maxDepth;
  if (!settings.directLight) shoot.shadowRays = &shadowRays;
  shoot.direct = settings.directLight;
  shoot.causticsOnly = settings.causticsOnly;
  shoot.emission = emission();
  if (usesMedia(scene)) shoot.emission.media = &emissiveMedia;
  shoot.inMedia = media;
  shoot.region = &region;
  shoot.splitPower = guidance.splitPower;
  return shoot;
}

EmissionSettings PhotonPass::emission() const {
  EmissionSettings starts;
  starts.mixture = &guidance.emission;
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

void PhotonPass::learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                               const ShootSettings& shoot, const ForwardControl& control,
                               ForwardStatistics& statistics) {
  region = probeRegion(scene, settings.weighting, statistics.counts);
  // A search for the nearest photons of one map needs photons of nearly equal power.
  guidance =
      recurse::learnGuidance(scene, classes, seed, shoot, region, control, statistics.counts, progressive);
  if (settings.without == Mechanism::SPLITTING) guidance.splitPower = INFINITE;
  if (guidance.emission.active())
    statistics.notes.push_back(formatted("%.0f %% of the photons are aimed at visible surfaces and openings",
                                         100 * guidance.emission.boxPart()));
}

void PhotonPass::learnStarts(const Scene& scene, const PathClasses& classes, const Pass& pass,
                             const ForwardControl& control, const LightSampler& shadowRays,
                             ForwardStatistics& statistics) {
  const ProcessorTimer timer(statistics.learningSeconds);
  guidance = {};
  media = {};
  learnOutsideMedium(scene, statistics);
  if (usesMedia(scene) && !emissiveMedia.learn(scene, outside, pass.seed, pass.time, statistics.counts))
    statistics.warnings.push_back("no sampled light from an emitting medium reached the scene: it adds no "
                                  "indirect light; check \"sigma_a\", \"Le\" and its boundary");
  if (settings.guided && scene.lights().size() > 0)
    learnGuidance(scene, classes, pass.seed, shootSettings(scene, shadowRays), control, statistics);
  if (usesMedia(scene))
    learnMedia(scene, classes, pass, shootSettings(scene, shadowRays), control, statistics);
}

void PhotonPass::buildMaps(const Scene& scene, const Pass& pass, ShotPhotons shot,
                           ForwardStatistics& statistics) {
  const auto start = std::chrono::steady_clock::now();
  const std::vector<float> lengths = causticsFirst(shot.onSurfaces, shot.lengths);
  const auto firstIndirect = std::stable_partition(shot.onSurfaces.begin(), shot.onSurfaces.end(),
                                                   [](const Photon& p) { return p.caustic; });
  causticLayer.map.build({shot.onSurfaces.begin(), firstIndirect}, settings.index);
  indirectLayer.map.build({firstIndirect, shot.onSurfaces.end()}, settings.index);
  if (!lengths.empty()) {
    const auto caustics = static_cast<size_t>(firstIndirect - shot.onSurfaces.begin());
    causticLayer.map.setLengths(std::span(lengths).first(caustics));
    indirectLayer.map.setLengths(std::span(lengths).subspan(caustics));
  }
  constexpr float WIDEST = 0.05f;       // maximum radius relative to the scene's; wider hides all detail
  constexpr float ONE_DIMENSION = 1.2f; // ratio of the optimal rates 1/5 (blur in one dimension) and 1/6
  const float widest = WIDEST * scene.bounds().radius;
  mediaPhotons.points.build(std::move(shot.inMedia), radiusOverFirst, widest);
  mediaPhotons.beams.build(std::move(shot.beams), std::pow(radiusOverFirst, ONE_DIMENSION), widest);
  if (settings.edges) mediaPhotons.points.findBounds(scene, pass.time, statistics.counts);
  statistics.photonsRefused = causticLayer.map.refused() + indirectLayer.map.refused();
  statistics.balanceSeconds = secondsSince(start);
  statistics.mapBytes =
      causticLayer.map.memoryBytes() + indirectLayer.map.memoryBytes() + mediaPhotons.memoryBytes();
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
  outside = 0;
  outsideTransmittance = Rgb(1);
  if (!scene.hasMedia()) return;
  outside = mediumOutside(scene, statistics.counts);
  const Medium* around = scene.medium(outside);
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
  constexpr uint64_t TRIALS = 4096, STREAM = 0x4d45444941ull;
  // Maximum points and beams stored for each emitted photon. Photons scatter hundreds of times in thick
  // media, and a ray passes a hundred times as many beams as points.
  constexpr double POINTS = 4, BEAMS = 0.25;
  const auto partOf = [](double wanted, size_t stored) {
    return static_cast<float>(std::min(1.0, wanted * double(TRIALS) / double(std::max<size_t>(1, stored))));
  };
  media.byBeams.assign(scene.mediumCount() + 1u, false);
  for (uint16_t i = 1; i <= scene.mediumCount(); ++i)
    media.byBeams[i] = settings.beams && keepsBeams(*scene.medium(i));
  shoot.photons = TRIALS;
  shoot.inMedia = media;
  Pass trial = pass;
  trial.seed = hashCombine(pass.seed, STREAM);
  const ShotPhotons shot = shootPhotons(scene, classes, trial, shoot, control);
  statistics.counts.add(shot.counts);
  media.pointPart = partOf(POINTS, shot.inMedia.size());
  media.beamPart = partOf(BEAMS, shot.beams.size());
}

} // namespace recurse
