/** @file
 * Photon tracing: the walk of one photon from its light through surfaces and media, until it ends.
 */
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "recurse/model/bsdf/scatteringPoint.h"
#include "transport/direct/directLight.h"
#include "transport/forward/photonStart.h"

namespace recurse {

/** Number of photons in a batch, the unit of parallel work. */
constexpr uint64_t PHOTON_BATCH = 4096;

/** Photons that walks have stored, by kind. */
struct StoredPhotons {
  std::vector<Photon> onSurfaces;
  std::vector<VolumePhoton> inMedia;
  std::vector<PhotonBeam> beams;
  PhotonPathLengths lengths;

  size_t size() const { return onSurfaces.size() + inMedia.size() + beams.size(); }
  void clear() {
    onSurfaces.clear();
    lengths = {};
    inMedia.clear();
    beams.clear();
  }
};

/** Traces photons and stores them at non-delta surfaces and in media. */
class PhotonWalk {
 public:
  PhotonWalk(const Scene& scene, const PathClasses& classes, const ShootSettings& settings,
             TransportCounts& counts, StoredPhotons& out)
      : scene(scene), classes(classes), settings(settings), counts(counts), out(out),
        starts(scene, classes, settings, counts) {}

  /** Shoots one photon. Returns the random numbers of its start and the inverse of their density. */
  EmissionGuide::TrainingSample shoot(Sampler sampler, float time) {
    const float light = sampler.next1D(), part = sampler.next1D();
    const Vec2f position = sampler.next2D(), direction = sampler.next2D();
    EmissionGuide::TrainingSample start{{light, part, position.x, position.y, direction.x, direction.y}, 1};
    if (settings.guide && settings.guide->active())
      start.weight = 1 / settings.guide->warp(start.numbers, sampler.next1D());
    const float byMedia = starts.byMedia();
    const bool fromMedium = byMedia > 0 && (byMedia >= 1 || sampler.next1D() < byMedia);
    storesDirect = settings.direct || fromMedium;
    std::optional<PhotonState> photon =
        fromMedium ? starts.fromMedium(start, time, sampler) : starts.fromLight(start, time, sampler);
    if (!photon) return start;
    if (record) photon->record = RecordedLightPath(*record);
    note(*photon, LightVertexKind::START, photon->ray.origin);
    walk(std::move(*photon), sampler);
    while (!waiting.empty()) {
      auto [next, ownSampler] = waiting.back();
      waiting.pop_back();
      walk(std::move(next), ownSampler);
    }
    return start;
  }

  std::vector<RecordedLightVertex>* record = nullptr; ///< of the next photons; null: they are not recorded

 private:
  static void note(PhotonState& photon, LightVertexKind kind, const Vec3f& position, bool stored = false) {
    photon.record.add(kind, photon.event, position, photon.flux, photon.state, stored);
  }

  /** Stores a short beam. The thinnest channel samples its length, so that no channel is amplified.
   */
  void storeBeam(const PhotonState& photon, const Medium& medium, uint16_t number, float end,
                 Sampler& sampler) {
    const float part = settings.inMedia.beamPart;
    if (part < 1 && sampler.next1D() >= part) return;
    const float distance =
        flight::sampleDistance(thinnest(medium.at(photon.ray.origin).extinction()), sampler);
    out.beams.push_back({photon.ray.origin, photon.ray.direction, std::min(end, distance), photon.flux / part,
                         number, photon.state.byte});
    if (classes.isTransient()) out.lengths.beams.push_back(photon.optical.length);
  }

  enum class MediumEvent { NONE, SCATTERED, ENDED };
  /** Samples the scattering event in the medium up to `end`. The photon is stored there, and scattered. */
  MediumEvent sampleMedium(PhotonState& photon, float end, Sampler& sampler) {
    const uint16_t number = photon.nesting.medium(scene);
    const Medium* medium = scene.medium(number);
    if (!medium) return MediumEvent::NONE;
    const LightState after = classes.step(photon.state, PathEvent::V);
    const bool stored =
        (!photon.straight || storesDirect) && photon.depth != settings.maxDepth && !classes.dead(after);
    const bool asBeam = settings.inMedia.isByBeams(number);
    if (stored && asBeam) storeBeam(photon, *medium, number, end, sampler);
    SpectralPath spectral{photon.flux, photon.pathPdf, Rgb(1)};
    const Collision c = sampleCollision(*medium, photon.ray, end, photon.hero, Absorption::SAMPLED, sampler,
                                        spectral, [](const Rgb&) {});
    // Roulette by the mean of the channels, which keeps powers nearly equal: the mean is constant where
    // single channels fluctuate with their densities.
    const float before = photon.flux.r + photon.flux.g + photon.flux.b;
    photon.flux = spectral.throughput;
    photon.pathPdf = spectral.pathPdf;
    if (isBlack(photon.flux)) return MediumEvent::ENDED;
    if (!c.scatters) return MediumEvent::NONE;
    if (settings.causticsOnly) return MediumEvent::ENDED;
    if (photon.depth == settings.maxDepth || classes.dead(after)) return MediumEvent::ENDED;
    photon.optical.travel(c.t);
    const Vec3f position = photon.ray.at(c.t), direction = photon.ray.direction;
    const float part = settings.inMedia.pointPart;
    const bool asPoint = stored && !asBeam && (part >= 1 || sampler.next1D() < part);
    if (asPoint) {
      out.inMedia.push_back(
          {position, packDirection(direction), photon.flux / part, number, photon.state.byte});
      if (classes.isTransient()) out.lengths.inMedia.push_back(photon.optical.length);
    }
    note(photon, LightVertexKind::MEDIUM, position, asPoint);
    ++photon.depth;
    const float chance = std::min(1.0f, (photon.flux.r + photon.flux.g + photon.flux.b) / before);
    if (!russianRoulette(chance, photon.depth, sampler, photon.flux)) return MediumEvent::ENDED;
    photon.state = after;
    photon.event = PathEvent::V;
    photon.caustic = photon.straight = false;
    photon.ratio = {};
    photon.ray.origin = position;
    photon.ray.direction = medium->phase->sample(direction, sampler.next2D());
    return MediumEvent::SCATTERED;
  }

  /** BSDF of the next surface that scatters; null if the photon ends before it. */
  const Bsdf* nextSurface(PhotonState& photon, Hit& hit, Sampler& sampler) {
    Ray& ray = photon.ray;
    for (;;) {
      const bool isHit = intersect(scene, ray, hit, counts);
      if (scene.hasMedia()) {
        if (isHit) photon.nesting.approach(hit, ray.direction);
        const MediumEvent event = sampleMedium(photon, isHit ? hit.t : INFINITE, sampler);
        if (event == MediumEvent::ENDED) return nullptr;
        if (event == MediumEvent::SCATTERED) continue;
      }
      if (!isHit) {
        note(photon, LightVertexKind::ESCAPE, ray.at(2 * scene.bounds().radius));
        return nullptr;
      }
      photon.optical.travel(hit.t);
      arena.reset();
      drawWavelength(scene, photon.wavelength, sampler, hit);
      const Bsdf* bsdf = bsdfAt(scene, hit, ray.direction, Footprint(), photon.nesting, arena);
      if (bsdf) return bsdf;
      photon.nesting.enterMedium(hit, ray.direction);
      if (scene.hasMedia())
        ray.origin = originBehind(ray, hit);
      else
        ray = spawn(hit.point, ray.direction);
    }
  }

  /** Arrival of a photon at a surface. */
  struct Arrival {
    const Hit& hit;
    ScatteringPoint scattering;
    Vec3f wi; ///< unit, back along the photon's path
    LightState afterD, afterS;
    LobeSet allowed = NO_LOBE; ///< lobes by which the photon may leave
  };

  Arrival arrive(PhotonState& photon, const Hit& hit, const Bsdf& bsdf) const {
    photon.ratio.arrive(photon.ray.direction, hit.point);
    const SurfaceKind kind = surfaceKind(classes, hit);
    Arrival at{hit, ScatteringPoint(bsdf, hit.point), -photon.ray.direction,
               classes.step(photon.state, PathEvent::D, kind),
               classes.step(photon.state, PathEvent::S, kind)};
    const bool endsHere = classes.dead(at.afterD) || settings.causticsOnly;
    at.allowed =
        LobeSet((endsHere ? NO_LOBE : NON_DELTA_LOBES) | (classes.dead(at.afterS) ? NO_LOBE : DELTA_LOBES));
    return at;
  }

  /** Scatters a photon by the BSDF of a surface, with Russian roulette if its new flux is below `power`.
   * Returns false if the photon ends. */
  bool scatter(PhotonState& photon, const Arrival& at, float power, Sampler& sampler) {
    const SurfacePoint& point = at.hit.point;
    const std::optional<Scatter> s = at.scattering.scatter(at.wi, Transport::FLUX, sampler, at.allowed);
    if (!s) return false;
    const Rgb scattered = photon.flux * s->weight;
    photon.flux = scattered;
    const float chance = std::min(1.0f, maxComponent(scattered) / power);
    if (!russianRoulette(chance, photon.depth, sampler, photon.flux)) return false;
    photon.state = s->specular() ? at.afterS : at.afterD;
    photon.event = s->specular() ? PathEvent::S : PathEvent::D;
    photon.flux *= dispersedColour(point, *s, photon.wavelength);
    photon.nesting.scatters(at.hit, at.wi, s->direction);
    photon.optical.scatter(s->eta);
    photon.caustic = photon.caustic && s->specular();
    photon.straight = photon.straight && passesPane(scene, at.scattering, *s);
    if (s->specular())
      photon.ratio.leave(s->direction, point);
    else
      photon.ratio = ratioAfter(photon.ratio, photon.depth - 1, at.hit, at.scattering, at.wi, s->direction);
    photon.ray = spawn(point, s->direction);
    return true;
  }

  /** Splits a strong photon into several at non-delta lobes; all but one are put on hold. At delta lobes one
   * photon carries the flux of all, since they would follow the same path. */
  void split(PhotonState& photon, Arrival& at, Sampler& sampler) {
    constexpr uint32_t SPLIT = 2000; // number of the fork, unused by other forks of the sampler
    const int count = splitCount(photon.flux, at.hit.point.position);
    if (count == 1) return;
    const float power = maxComponent(photon.flux) / static_cast<float>(count);
    const auto branch = [&](PhotonState copy, int i) {
      Sampler own = sampler.fork(SPLIT + static_cast<uint32_t>(i));
      if (scatter(copy, at, power, own)) waiting.emplace_back(std::move(copy), own);
    };
    const LobeSet allowed = at.allowed;
    at.allowed = LobeSet(allowed & DELTA_LOBES);
    branch(photon, 0);
    at.allowed = LobeSet(allowed & NON_DELTA_LOBES);
    photon.flux /= static_cast<float>(count);
    for (int i = 1; i < count; ++i) branch(photon, i);
  }

  /** Follows a photon until it ends. */
  void walk(PhotonState photon, Sampler& sampler) {
    Hit hit;
    while (const Bsdf* bsdf = nextSurface(photon, hit, sampler)) {
      if (photon.depth == settings.maxDepth) return;
      Arrival at = arrive(photon, hit, *bsdf);
      const bool keepsPhotons = at.scattering.keepsPhotons();
      const bool isStored =
          keepsPhotons && !classes.dead(at.afterD) && (!photon.straight || storesDirect) && store(photon, at);
      note(photon, LightVertexKind::SURFACE, hit.point.position, isStored);
      ++photon.depth;
      if (keepsPhotons) split(photon, at, sampler);
      if (!scatter(photon, at, maxComponent(photon.flux), sampler)) return;
    }
  }

  /** Number of photons that a photon is split into. Without a split, the few photons far stronger than most
   * in the visible region would each light a whole room from one direction. */
  int splitCount(const Rgb& flux, const Vec3f& position) const {
    constexpr float MAX_COUNT = 256;
    const float count = maxComponent(flux) / settings.splitPower;
    if (!(count > 2) || !settings.region->contains(position)) return 1;
    return static_cast<int>(std::min(count, MAX_COUNT));
  }

  /** Reverse ratio after a non-delta event: from the light's densities at depth 0, else by furtherOn(). */
  ReverseRatio ratioAfter(const ReverseRatio& before, int depth, const Hit& hit,
                          const ScatteringPoint& scattering, const Vec3f& wi, const Vec3f& direction) const {
    // Not for fibres: both techniques would have to agree on the normal of a curve.
    if (!settings.shadowRays || !scattering.keepsPhotons()) return {};
    if (depth > 0)
      return before.furtherOn(scattering.pdfNonDelta(direction, wi), scattering.pdfNonDelta(wi, direction),
                              direction, hit.point);
    const LightSampler& sampler = *settings.shadowRays;
    const PhotonOrigin& origin = starts.origin;
    const float chosen =
        sampler.probability(scene.lights(), lightSampleContext(sampler, hit.point, direction), origin.light);
    const float arrivals =
        arrivalDensity(origin.kind, origin.pdf, glm::distance(origin.position, hit.point.position),
                       absDot(wi, hit.point.geometricNormal), origin.probability, chosen);
    return ReverseRatio::atSurface(arrivals, scattering.pdfNonDelta(wi, direction), direction, hit.point);
  }

  /** Packs a direction without a change of side: rounding could hide a grazing photon from all queries. */
  static PackedDirection packOnSide(const Vec3f& wi, const Vec3f& normal) {
    PackedDirection packed = packDirection(wi);
    const float cosine = glm::dot(wi, normal);
    if (std::abs(cosine) > 1e-4f) return packed; // larger than the packing error
    const Vec3f up = normal * std::copysign(1.0f, cosine);
    for (float lift = 4e-5f; glm::dot(unpackDirection(packed), up) < 1e-6f; lift *= 2)
      packed = packDirection(glm::normalize(wi + up * lift));
    return packed;
  }

  /** Stores a photon. Returns false where it is parallel to the surface: no flux. */
  bool store(const PhotonState& photon, const Arrival& at) {
    const SurfacePoint& point = at.hit.point;
    if (glm::dot(at.wi, point.geometricNormal) == 0) return false;
    Photon p;
    p.position = point.position;
    p.direction = packOnSide(at.wi, point.geometricNormal);
    p.normal = packDirection(point.normalTowards(at.wi));
    p.power = photon.flux;
    p.pathState = photon.state.byte;
    p.caustic = photon.caustic;
    p.reverseRatio = photon.ratio.value();
    out.onSurfaces.push_back(p);
    if (classes.isTransient()) out.lengths.onSurfaces.push_back(photon.optical.length);
    return true;
  }

  const Scene& scene;
  const PathClasses& classes;
  const ShootSettings& settings;
  TransportCounts& counts;
  StoredPhotons& out;
  std::vector<std::pair<PhotonState, Sampler>> waiting;
  PhotonStart starts;
  bool storesDirect = true; ///< see ShootSettings::direct
  BsdfArena arena;
};

} // namespace recurse
