/** @file
 * Photon tracing: the walk of one photon from its light through surfaces and media, until it ends.
 */
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "transport/direct/directLight.h"
#include "transport/forward/shootSettings.h"
#include "transport/paths/recordedWalk.h"
#include "transport/paths/walker.h"
#include "transport/weights/mergeWeights.h"

namespace recurse {

/** Number of photons in a batch, the unit of parallel work. */
constexpr uint64_t PHOTON_BATCH = 4096;

/** Photon between two scattering events. */
struct PhotonPath {
  LightSubpath path;
  ReverseRatio ratio;
  bool caustic = true;  ///< only delta events are between the light and the photon
  bool straight = true; ///< only thin panes are between the light and the photon
  RecordedWalk record{nullptr, 1};
};

/** Traces photons and stores them at non-delta surfaces and in media. */
class PhotonWalk {
 public:
  PhotonWalk(const Scene& scene, const PathClasses& classes, const ShootSettings& settings,
             TransportCounts& counts, StoredPhotons& out)
      : scene(scene), classes(classes), settings(settings), out(out),
        starts(scene, classes, settings.emission, counts), walker(scene, classes, counts, settings.maxDepth) {
  }

  /** Shoots one photon. Returns its start; null where nothing is emitted. */
  const LightStart* shoot(Sampler sampler, float time) {
    origin = starts.start(time, sampler);
    if (!origin) return nullptr;
    storesDirect = settings.direct || !origin->end.light;
    PhotonPath photon;
    photon.path = origin->path;
    const auto photons = static_cast<float>(settings.photons);
    photon.path.throughput /= photons;
    splitPower = std::max(settings.splitPower / photons, maxComponent(photon.path.throughput) / MAX_SPLIT);
    if (origin->end.light && origin->end.isIntersectable())
      photon.ratio = ReverseRatio::atLight(origin->end.ray, origin->pdf, origin->probability);
    photon.record = RecordedWalk(record, 1);
    photon.record.start(photon.path);
    walk(photon, sampler);
    while (!waiting.empty()) {
      auto [next, ownSampler] = waiting.back();
      waiting.pop_back();
      walk(next, ownSampler);
    }
    return &*origin;
  }

  std::vector<RecordedLightVertex>* record = nullptr; ///< of the next photons; null: they are not recorded

 private:
  /** Whether a photon is stored where it scatters next, unless its path classes forbid it. */
  bool isStorable(const PhotonPath& photon) const { return !photon.straight || storesDirect; }

  /** Follows a photon until it ends. */
  void walk(PhotonPath& photon, Sampler& sampler) {
    LightSubpath& path = photon.path;
    const auto flight = [&](uint16_t medium, float end) { storeBeam(photon, medium, end, sampler); };
    while (walker.next(
        path, vertex, sampler, photon.record.escape(path, scene), [](const Rgb&) {}, flight)) {
      bool isStored = false, isSplit = true;
      if (vertex.medium) {
        if (settings.causticsOnly) return;
        isStored = storeInMedium(photon, sampler);
        photon.record.arrive(path, vertex, isStored);
      } else {
        photon.ratio.arrive(path.ray.direction, vertex.point());
        if (settings.causticsOnly) vertex.allowed = LobeSet(vertex.allowed & DELTA_LOBES);
        isSplit = vertex.scattering->keepsPhotons();
        isStored = isSplit && !classes.dead(vertex.afterD) && isStorable(photon) && store(photon);
        photon.record.arrive(path, vertex, isStored);
      }
      if (isSplit) split(photon, sampler);
      if (!scatter(photon, sampler)) return;
    }
  }

  /** Scatters a photon. `keptPart`: see Walker::scatter(). Returns false if the photon ends. */
  bool scatter(PhotonPath& photon, Sampler& sampler, float keptPart = 1) {
    const std::optional<Scatter> s = walker.scatter(photon.path, vertex, sampler, keptPart);
    if (!s) return false;
    photon.record.leave(vertex, *s);
    if (vertex.medium) {
      photon.caustic = photon.straight = false;
      photon.ratio = {};
      return true;
    }
    photon.caustic = photon.caustic && s->specular();
    photon.straight = photon.straight && passesPane(scene, *vertex.scattering, *s);
    if (s->specular())
      photon.ratio.leave(s->direction, vertex.point());
    else
      photon.ratio = ratioAfter(photon.ratio, s->direction);
    return true;
  }

  /** Splits a strong photon into several at non-delta lobes and in media; all but one are put on hold. At
   * delta lobes one photon carries the flux of all, since they would follow the same path. */
  void split(PhotonPath& photon, Sampler& sampler) {
    constexpr uint32_t SPLIT_STREAM = 2000; // number of the fork, unused by other forks of the sampler
    // Splits would undo the roulette outside of the scene.
    const int count = splitCount(photon.path.throughput / photon.path.farthest);
    if (count == 1) return;
    const float fraction = 1 / static_cast<float>(count);
    const auto branch = [&](PhotonPath copy, int i, float keptFraction) {
      Sampler branchSampler = sampler.fork(SPLIT_STREAM + static_cast<uint32_t>(i));
      if (scatter(copy, branchSampler, keptFraction)) waiting.emplace_back(copy, branchSampler);
    };
    const LobeSet allowed = vertex.allowed;
    vertex.allowed = LobeSet(allowed & DELTA_LOBES);
    branch(photon, 0, fraction);
    vertex.allowed = LobeSet(allowed & NON_DELTA_LOBES);
    photon.path.throughput *= fraction;
    for (int i = 1; i < count; ++i) branch(photon, i, 1);
  }

  /** Number of photons that a photon is split into. Without a split, the few photons far stronger than most
   * in the visible region would each light a whole room from one direction. */
  int splitCount(const Rgb& flux) const {
    const float count = maxComponent(flux) / splitPower;
    if (count <= 2) return 1;
    const Vec3f& position = vertex.point().position;
    const bool isVisible = vertex.medium ? settings.region->importanceInMedium(position) > 0
                                         : settings.region->contains(position);
    return isVisible ? static_cast<int>(count) : 1;
  }

  /** Reverse ratio after a non-delta event: from the light's densities at the first, else by furtherOn(). */
  ReverseRatio ratioAfter(const ReverseRatio& before, const Vec3f& direction) const {
    const ScatteringPoint& scattering = *vertex.scattering;
    const SurfacePoint& point = vertex.point();
    // keepsPhotons() is false for fibres: photons and rays would need the same normal on a curve.
    if (!settings.shadowRays || !origin->end.light || !scattering.keepsPhotons()) return {};
    const float pdf = scattering.pdfNonDelta(vertex.wi, direction);
    if (vertex.depth > 1)
      return before.furtherOn(scattering.pdfNonDelta(direction, vertex.wi), pdf, direction, point);
    const LightSampler& sampler = *settings.shadowRays;
    const LightEnd& end = origin->end;
    const float chosen =
        sampler.probability(scene.lights(), lightSampleContext(sampler, point, direction), end.index);
    const float arrivals =
        arrivalDensity(end.light->kind(), origin->pdf, glm::distance(end.ray.origin, point.position),
                       absDot(vertex.wi, point.geometricNormal), origin->probability, chosen);
    return ReverseRatio::atSurface(arrivals, pdf, direction, point);
  }

  /** Stores a photon. Returns false where it is parallel to the surface: no flux. */
  bool store(const PhotonPath& photon) {
    std::optional<Photon> p = photonAt(vertex.point(), vertex.wi, vertex.throughput, vertex.state.byte);
    if (!p) return false;
    p->caustic = photon.caustic;
    p->reverseRatio = photon.ratio.value();
    out.onSurfaces.push_back(*p);
    if (classes.isTransient()) out.lengths.push_back(photon.path.optical.length);
    return true;
  }

  /** Stores a photon that a medium scatters, unless the medium stores beams. Returns whether it is stored. */
  bool storeInMedium(const PhotonPath& photon, Sampler& sampler) {
    const uint16_t number = photon.path.nesting.medium(scene);
    const float storedFraction = settings.inMedia.pointPart;
    if (!isStorable(photon) || vertex.allowed == NO_LOBE || settings.inMedia.isByBeams(number) ||
        (storedFraction < 1 && sampler.next1D() >= storedFraction))
      return false;
    out.inMedia.push_back({vertex.point().position, packDirection(-vertex.wi),
                           vertex.throughput / storedFraction, number, vertex.state.byte,
                           photon.path.optical.length});
    return true;
  }

  /** Stores a short beam along the flight of a photon through a medium that stores beams. The thinnest
   * channel samples the beam's length, so that no channel is amplified. */
  void storeBeam(const PhotonPath& photon, uint16_t number, float end, Sampler& sampler) {
    const LightSubpath& path = photon.path;
    const float storedFraction = settings.inMedia.beamPart;
    if (!settings.inMedia.isByBeams(number) || !isStorable(photon) || path.depth == settings.maxDepth ||
        classes.dead(classes.step(path.state, PathEvent::V)) ||
        (storedFraction < 1 && sampler.next1D() >= storedFraction))
      return;
    const float distance =
        flight::sampleDistance(thinnest(scene.medium(number)->at(path.ray.origin).extinction()), sampler);
    out.beams.push_back({path.ray.origin, path.ray.direction, std::min(end, distance),
                         path.throughput / storedFraction, number, path.state.byte, path.optical.length});
  }

  const Scene& scene;
  const PathClasses& classes;
  const ShootSettings& settings;
  StoredPhotons& out;
  std::vector<std::pair<PhotonPath, Sampler>> waiting;
  EmissionSampler starts;
  Walker<LightState> walker;
  std::optional<LightStart> origin; ///< start of the current photon
  LightVertex vertex;               ///< latest vertex of the current photon
  bool storesDirect = true;         ///< see ShootSettings::direct
  /** Maximum number of photons that one emitted photon is split into, at all its surfaces together. */
  static constexpr float MAX_SPLIT = 256;
  float splitPower = INFINITE; ///< approximate power of each photon that the current one is split into [W]
};

} // namespace recurse
