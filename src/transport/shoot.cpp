/** @file
 * Photon walks.
 */
#include "recurse/transport/shoot.h"

#include <algorithm>
#include <cstring>
#include <mutex>
#include <numeric>
#include <span>
#include <type_traits>
#include <utility>

#include "recurse/core/memory.h"
#include "recurse/core/parallel.h"
#include "recurse/core/text.h"
#include "recurse/model/scatteringPoint.h"
#include "recurse/transport/directLight.h"
#include "recurse/transport/mergeWeights.h"
#include "recurse/transport/walk.h"

namespace recurse {

namespace {

/** Tells photon samples from those of pixels. */
constexpr uint64_t PHOTON_STREAM = 0x50484f544f4e53ull, TRIAL_STREAM = 0x545249414c53ull;
constexpr uint64_t BATCH = 4096;
/** Enough of them to keep threads busy and to count what is stored. */
constexpr size_t FIRST_BATCHES = 64;
/** Photons are stored in the order of their emission, then in that of the tree. */
constexpr double MAP_COPIES = 2;
/** Nearer than so many radii the target is too wide for a cone. */
constexpr float NEAR_TARGET = 1.5f;

/** What walks leave behind. */
struct StoredPhotons {
  std::vector<Photon> onSurfaces;
  std::vector<VolumePhoton> inMedia;
  std::vector<PhotonBeam> beams;

  size_t size() const { return onSurfaces.size() + inMedia.size() + beams.size(); }
  void clear() {
    onSurfaces.clear();
    inMedia.clear();
    beams.clear();
  }
};

class PhotonWalk {
 public:
  PhotonWalk(const Scene& scene, const PathClasses& classes, const ShootSettings& settings,
             TransportCounts& counts, StoredPhotons& out)
      : scene(scene), classes(classes), settings(settings), counts(counts), out(out) {}

  /** Returns what the photon started by, and one over its density. */
  EmissionGuide::TrainingSample shoot(Sampler sampler, float time) {
    const float light = sampler.next1D(), part = sampler.next1D();
    const Vec2f place = sampler.next2D(), direction = sampler.next2D();
    EmissionGuide::TrainingSample start{{light, part, place.x, place.y, direction.x, direction.y}, 1};
    auto& n = start.numbers;
    if (settings.guide && settings.guide->active())
      start.weight = 1 / settings.guide->warp(n, sampler.next1D());
    base = entered = 0;
    float pick = n[0];
    const LightTable& lights = settings.lights ? *settings.lights : scene.lights();
    const float byMedia = partOfMedia(lights);
    storesDirect = settings.direct;
    if (byMedia > 0 && (byMedia >= 1 || sampler.next1D() < byMedia)) {
      storesDirect = true;
      shootFromMedium(n, start.weight / byMedia, time, sampler);
      return start;
    }
    const size_t index = lights.chooseIndex(pick);
    const Light& source = lights[index];
    if (!(lights.probability(index) > 0)) return start;
    const bool aimed = settings.aim && settings.aim->isAimed(static_cast<uint32_t>(index));
    const Vec2f towards{n[4], n[5]};
    std::optional<LeSample> emission =
        source.sampleLe({n[1], {n[2], n[3]}, aimed ? sampler.next2D() : towards, time});
    if (!emission) return start;
    if (aimed) settings.aim->redirect(source, *emission, pick, towards);
    if (isBlack(emission->flux)) return start;
    LePdf pdf = source.pdfLe(*emission);
    if (aimed) pdf.direction = emission->pdfDirection;
    if (source.isInfinite() && settings.portals && settings.portals->active()) {
      settings.portals->redirect(*emission, pick, {n[2], n[3]});
      pdf.position = emission->pdfPosition;
    }
    const ReverseRatio ratio =
        source.isMet() ? ReverseRatio::atLight(*emission, pdf, lights.probability(index)) : ReverseRatio();
    origin = {source.kind(), pdf, emission->origin, static_cast<uint32_t>(index), lights.probability(index)};
    const Rgb flux =
        emission->flux / (lights.probability(index) * (1 - byMedia) * static_cast<float>(settings.photons));
    base = maxComponent(flux);
    if (!recurse::isFinite(flux)) {
      ++counts.nonFinite;
      return start;
    }
    if (classes.dead(classes.lightStart())) return start;
    const Ray ray{emission->origin, emission->direction, INFINITE, time};
    Flight flight{ray, flux * start.weight, classes.lightStart(), nestingAt(scene, ray, counts), ratio};
    if (scene.hasMedia()) {
      const uint16_t declared = scene.lightMedium(index);
      flight.nesting.startIn(declared ? declared : mediumAround(scene, ray, 0, counts));
      flight.hero = std::min(2, static_cast<int>(3 * sampler.next1D()));
    }
    walk(std::move(flight), sampler);
    while (!waiting.empty()) {
      auto [flight, own] = waiting.back();
      waiting.pop_back();
      walk(std::move(flight), own);
    }
    return start;
  }
  /** Power of a photon that starts with weight 1, of the last one that was shot. */
  float fullPower() const { return base; }
  /** How much of what is seen, in so much of a surface, lies where it came into a target straight from the
   * light. */
  float enteredImportance() const { return entered; }

  const VisibleRegion* region = nullptr; ///< of trial photons
  uint64_t sent = 0, arrived = 0;        ///< photons to targets, and those that came down in the region

 private:
  /** A photon on its way. */
  struct Flight {
    Ray ray;
    Rgb flux;
    LightState state;
    Nesting nesting;
    ReverseRatio ratio;
    int depth = 0;
    bool caustic = true;
    bool straight = true; ///< from the light: nothing but thin panes so far
    float lowered = 1;    ///< power over that of the photon that was sent nowhere
    float wavelength = 0; ///< as in Subpath
    // In media:
    Rgb own{1};   ///< see SpectralPath
    int hero = 0; ///< the channel that draws distances
  };

  /** Of the photons, that glowing media emit: by power, but where there are lights too not nearly all. */
  float partOfMedia(const LightTable& lights) const {
    constexpr double MOST = 0.9;
    if (!settings.media || settings.media->empty()) return 0;
    double byLights = 0;
    for (size_t i = 0; i < lights.size(); ++i) byLights += double(maxComponent(lights[i].power()));
    if (!(byLights > 0)) return 1;
    const double byMedia = settings.media->power();
    return static_cast<float>(std::clamp(byMedia / (byMedia + byLights), 1 - MOST, MOST));
  }

  /** A photon of a glowing medium, `weight` over the density of all that was chosen before. */
  void shootFromMedium(const EmissionGuide::Numbers& n, float weight, float time, Sampler& sampler) {
    auto [position, nesting, power] = settings.media->sample(scene, time, n[0], {n[1], n[2], n[3]}, counts);
    const Rgb flux = power * (weight / static_cast<float>(settings.photons));
    if (isBlack(flux)) return;
    if (!recurse::isFinite(flux)) {
      ++counts.nonFinite;
      return;
    }
    if (classes.dead(classes.lightStart())) return;
    const Ray ray{position, uniformSphere({n[4], n[5]}), INFINITE, time};
    Flight flight{ray, flux, classes.lightStart(), nesting, {}};
    flight.hero = std::min(2, static_cast<int>(3 * sampler.next1D()));
    walk(std::move(flight), sampler);
  }

  /** A short beam: as far as a flight by the thinnest channel goes, of which no channel is then amplified. */
  void storeBeam(const Flight& flight, const Medium& medium, uint16_t number, float end, Sampler& sampler) {
    const float part = settings.inMedia.beamPart;
    if (part < 1 && sampler.next1D() >= part) return;
    const float distance =
        flight::sampleDistance(thinnest(medium.at(flight.ray.origin).extinction()), sampler);
    out.beams.push_back({flight.ray.origin, flight.ray.direction, std::min(end, distance), flight.flux / part,
                         number, flight.state.byte});
  }

  enum class Through { PASSES, SCATTERS, ENDS };
  /** Flies through the medium on the way to `end`. Where it scatters a photon is stored, and sent on. */
  Through flyInMedium(Flight& flight, float end, Sampler& sampler) {
    const uint16_t number = flight.nesting.medium(scene);
    const Medium* medium = scene.medium(number);
    if (!medium) return Through::PASSES;
    const LightState after = classes.step(flight.state, PathEvent::V);
    const bool stored =
        (!flight.straight || storesDirect) && flight.depth != settings.maxDepth && !classes.dead(after);
    const bool asBeam = settings.inMedia.isByBeams(number);
    if (stored && asBeam) storeBeam(flight, *medium, number, end, sampler);
    SpectralPath spectral{flight.flux, flight.own, Rgb(1)};
    const Collision c =
        flyThrough(*medium, flight.ray, end, flight.hero, sampler, spectral, [](const Rgb&) {});
    // Single channels go up and down with their densities; their mean does not, and roulette by it keeps
    // powers alike.
    const float before = flight.flux.r + flight.flux.g + flight.flux.b;
    flight.flux = spectral.throughput;
    flight.own = spectral.own;
    if (isBlack(flight.flux)) return Through::ENDS;
    if (!c.scatters) return Through::PASSES;
    if (flight.depth == settings.maxDepth) {
      counts.truncatedThroughput += double(maxComponent(flight.flux));
      return Through::ENDS;
    }
    if (classes.dead(after)) return Through::ENDS;
    const Vec3f position = flight.ray.at(c.t), direction = flight.ray.direction;
    const float part = settings.inMedia.pointPart;
    if (stored && !asBeam && (part >= 1 || sampler.next1D() < part))
      out.inMedia.push_back(
          {position, packDirection(direction), flight.flux / part, number, flight.state.byte});
    ++flight.depth;
    const float chance = std::min(1.0f, (flight.flux.r + flight.flux.g + flight.flux.b) / before);
    if (!russianRoulette(chance, flight.depth, sampler, flight.flux)) return Through::ENDS;
    flight.state = after;
    flight.caustic = flight.straight = false;
    flight.ratio = {};
    flight.ray.origin = position;
    flight.ray.direction = medium->phase->sample(direction, sampler.next2D());
    return Through::SCATTERS;
  }

  void walk(Flight flight, Sampler& sampler) {
    auto& [ray, flux, state, nesting, ratio, depth, caustic, straight, lowered, wavelength, own, hero] =
        flight;
    Hit hit;
    bool toTarget = lowered < 1; // and has not come down yet
    for (;;) {
      const bool met = intersect(scene, ray, hit, counts);
      if (scene.hasMedia()) {
        if (met) nesting.approach(hit, ray.direction);
        const Through through = flyInMedium(flight, met ? hit.t : INFINITE, sampler);
        if (through == Through::ENDS) return;
        if (through == Through::SCATTERS) continue;
      }
      if (!met) return;
      arena.reset();
      drawWavelength(scene, wavelength, sampler, hit);
      const Bsdf* bsdf = bsdfAt(scene, hit, ray.direction, Footprint(), nesting, arena);
      if (!bsdf) {
        nesting.enterMedium(hit, ray.direction);
        if (scene.hasMedia())
          ray.origin = originBehind(ray, hit);
        else
          ray = spawn(hit.point, ray.direction);
        continue;
      }
      if (depth == settings.maxDepth) {
        counts.truncatedThroughput += double(maxComponent(flux));
        return;
      }
      if (region && depth == 0)
        for (const DxtranSphere& t : settings.targets)
          if (glm::distance(hit.point.position, t.center) < t.radius) entered += t.importance;
      const bool outside = !settings.targets.empty() && findCones(hit.point.position);
      if (std::exchange(toTarget, false) && region) arrived += region->contains(hit.point.position);
      if (outside && lowered < 1) {
        if (!russianRoulette(lowered, depth, sampler, flux)) return;
        lowered = 1;
      }
      const ScatteringPoint scattering(*bsdf, hit.point);
      const Vec3f wi = -ray.direction;
      ratio.arrive(ray.direction, hit.point);
      const LightState stateD = classes.step(state, PathEvent::D), stateS = classes.step(state, PathEvent::S);
      if (scattering.keepsPhotons() && !classes.dead(stateD) && (!straight || storesDirect))
        store(hit.point, scattering, wi, flux, state, caustic, ratio);
      ++depth;
      const LobeSet allowed = LobeSet((classes.dead(stateD) ? NO_LOBE : NON_DELTA_LOBES) |
                                      (classes.dead(stateS) ? NO_LOBE : DELTA_LOBES));
      const bool sends = outside && (allowed & NON_DELTA_LOBES) && (scattering.lobes() & LAMBERTIAN);
      if (sends) sendToTargets(flight, hit, scattering, stateD, sampler);
      const auto goOn = [&](Flight& f, Sampler& own) {
        const std::optional<Scatter> s = scattering.scatter(wi, Transport::FLUX, own, allowed);
        if (!s || (sends && !s->specular() && conesAround(s->direction) > 0)) return false;
        const Rgb scattered = f.flux * s->weight;
        const float before = maxComponent(f.flux), after = maxComponent(scattered);
        f.flux = scattered;
        if (!russianRoulette(std::min(1.0f, after / before), f.depth, own, f.flux)) return false;
        f.state = s->specular() ? stateS : stateD;
        f.flux *= dispersedColour(hit.point, *s, f.wavelength);
        f.nesting.scatters(hit, wi, s->direction);
        f.caustic = f.caustic && s->specular();
        f.straight = f.straight && passesPane(scene, scattering, *s);
        if (s->specular())
          f.ratio.leave(s->direction, hit.point);
        else
          f.ratio = ratioAfter(f.ratio, f.depth - 1, hit, scattering, wi, s->direction);
        f.ray = spawn(hit.point, s->direction);
        return true;
      };
      constexpr uint32_t SPLIT = 2000; // not to be confused with others of the same sampler
      const int count = scattering.keepsPhotons() ? splitCount(flux, hit.point.position) : 1;
      flux /= static_cast<float>(count);
      for (int i = 1; i < count; ++i) {
        Flight copy = flight;
        Sampler own = sampler.fork(SPLIT + static_cast<uint32_t>(i));
        if (goOn(copy, own)) waiting.emplace_back(std::move(copy), own);
      }
      if (!goOn(flight, sampler)) return;
    }
  }

  /** How many a photon becomes. Those that carry far more than most where it is seen, because few started
   * there, would each light a whole room in a direction of their own. */
  int splitCount(const Rgb& flux, const Vec3f& position) const {
    constexpr float MAX_COUNT = 256;
    const float count = maxComponent(flux) / settings.splitPower;
    if (!(count > 2) || !settings.region->contains(position)) return 1;
    return static_cast<int>(std::min(count, MAX_COUNT));
  }

  /** Where the photon comes from. */
  struct Origin {
    LightKind kind = LightKind::POINT;
    LePdf pdf;
    Vec3f position{0};
    uint32_t light = 0;
    float probability = 0; ///< of the light
  };

  /** Of a photon that leaves a surface by a non-delta lobe: known for what came straight from the light. */
  ReverseRatio ratioAfter(const ReverseRatio& before, int depth, const Hit& hit,
                          const ScatteringPoint& scattering, const Vec3f& wi, const Vec3f& direction) const {
    // Both ends would have to agree on the normal of a curve.
    if (!settings.shadowRays || !scattering.keepsPhotons()) return {};
    if (depth > 0)
      return before.furtherOn(scattering.pdfNonDelta(direction, wi), scattering.pdfNonDelta(wi, direction),
                              direction, hit.point);
    const LightSampler& sampler = *settings.shadowRays;
    const float chosen =
        sampler.probability(scene.lights(), lightSampleContext(sampler, hit.point, direction), origin.light);
    const float arrivals =
        arrivalDensity(origin.kind, origin.pdf, glm::distance(origin.position, hit.point.position),
                       absDot(wi, hit.point.geometricNormal), origin.probability, chosen);
    return ReverseRatio::atSurface(arrivals, scattering.pdfNonDelta(wi, direction), direction, hit.point);
  }

  /** What is seen of a target from a place outside. */
  struct Target {
    Cone cone;
    float part;
  };
  /** The targets that photons are sent to from a place. True when it is outside of all. */
  bool findCones(const Vec3f& from) {
    cones.clear();
    for (const DxtranSphere& t : settings.targets) {
      if (!(lengthSquared(t.center - from) > square(NEAR_TARGET * t.radius))) return false;
      cones.push_back({Cone::toSphere(from, t.center, t.radius), t.part});
    }
    return true;
  }
  std::ptrdiff_t conesAround(const Vec3f& direction) const {
    return std::count_if(cones.begin(), cones.end(),
                         [&](const Target& t) { return t.cone.contains(direction); });
  }

  /** Photons to the targets from where `from` has scattered. */
  void sendToTargets(const Flight& from, const Hit& hit, const ScatteringPoint& scattering, LightState state,
                     const Sampler& sampler) {
    constexpr float MIN_COUNT = 0.01f, MAX_COUNT = 16;
    constexpr uint32_t BRANCH = 1000; // not to be confused with others of the same sampler
    const Vec3f wi = -from.ray.direction;
    const Vec3f normal = scattering.normal() * std::copysign(1.0f, glm::dot(scattering.normal(), wi));
    const float albedo = PI * maxComponent(scattering.evaluateFlux(wi, normal));
    Sampler branch = sampler.fork(BRANCH);
    for (const auto& [cone, part] : cones) {
      const float lifted = glm::dot(normal, cone.axis);
      // Below the surface altogether: the sine of half the angle is the root of opening · (2 - opening).
      if (lifted < 0 && square(lifted) > cone.opening * (2 - cone.opening)) continue;
      const float seen = 2 * cone.opening * albedo * std::max(lifted, 0.0f);
      const float wanted = std::clamp(maxComponent(from.flux) * seen / (base * part), MIN_COUNT, MAX_COUNT);
      const int count = static_cast<int>(wanted + branch.next1D());
      for (int i = 0; i < count; ++i) {
        Sampler own = branch.fork(static_cast<uint32_t>(i));
        const Vec3f direction = cone.sample(own.next2D());
        Flight sentOut = from;
        const float density = wanted *
                              static_cast<float>(std::max<std::ptrdiff_t>(1, conesAround(direction))) /
                              (2 * PI * cone.opening);
        sentOut.flux *= scattering.evaluateFlux(wi, direction) / density;
        if (isBlack(sentOut.flux)) continue;
        sentOut.lowered = std::min(1.0f, maxComponent(sentOut.flux) / maxComponent(from.flux));
        sentOut.state = state;
        sentOut.caustic = sentOut.straight = false;
        sentOut.ratio = ratioAfter(from.ratio, from.depth - 1, hit, scattering, wi, direction);
        sentOut.nesting.scatters(hit, wi, direction);
        sentOut.ray = spawn(hit.point, direction);
        waiting.emplace_back(std::move(sentOut), own);
        ++sent;
      }
    }
  }

  /** Rounding must not send a photon that only grazes the surface below it, where no search would find it. */
  static PackedDirection packOnSide(const Vec3f& wi, const Vec3f& normal) {
    PackedDirection packed = packDirection(wi);
    const float cosine = glm::dot(wi, normal);
    if (std::abs(cosine) > 1e-4f) return packed; // packing turns it by less
    const Vec3f up = normal * std::copysign(1.0f, cosine);
    for (float lift = 4e-5f; glm::dot(unpackDirection(packed), up) < 1e-6f; lift *= 2)
      packed = packDirection(glm::normalize(wi + up * lift));
    return packed;
  }

  void store(const SurfacePoint& point, const ScatteringPoint& scattering, const Vec3f& wi, const Rgb& flux,
             LightState state, bool caustic, const ReverseRatio& ratio) {
    const float geometric = absDot(wi, point.geometricNormal);
    if (geometric == 0) return; // in the plane of the surface: brings no flux
    Photon p;
    p.position = point.position;
    p.direction = packOnSide(wi, point.geometricNormal);
    p.normal = packDirection(point.normalTowards(wi));
    p.power = flux * (absDot(wi, scattering.normal()) / geometric);
    p.pathState = state.byte;
    p.caustic = caustic;
    p.reverseRatio = ratio.value();
    out.onSurfaces.push_back(p);
  }

  const Scene& scene;
  const PathClasses& classes;
  const ShootSettings& settings;
  TransportCounts& counts;
  StoredPhotons& out;
  std::vector<std::pair<Flight, Sampler>> waiting;
  std::vector<Target> cones; ///< of the last surface
  Origin origin;
  float base = 0, entered = 0;
  bool storesDirect = true; ///< see ShootSettings::direct
  BsdfArena arena;
};

template <class T> void appendBytes(const std::vector<T>& values, std::vector<std::byte>& out) {
  static_assert(std::is_trivially_copyable_v<T>);
  const uint64_t count = values.size();
  for (const auto& part : {std::as_bytes(std::span(&count, 1)), std::as_bytes(std::span(values))})
    out.insert(out.end(), part.begin(), part.end());
}

template <class T> void readBytes(std::span<const std::byte>& bytes, std::vector<T>& values) {
  uint64_t count = 0;
  std::memcpy(&count, bytes.data(), sizeof count);
  values.resize(count);
  const auto own = bytes.subspan(sizeof count, count * sizeof(T));
  if (!own.empty()) std::memcpy(static_cast<void*>(values.data()), own.data(), own.size());
  bytes = bytes.subspan(sizeof count + own.size());
}

/** Photons of a batch for another process. */
std::vector<std::byte> packed(const StoredPhotons& stored) {
  std::vector<std::byte> out;
  appendBytes(stored.onSurfaces, out);
  appendBytes(stored.inMedia, out);
  appendBytes(stored.beams, out);
  return out;
}

void unpack(std::span<const std::byte> bytes, StoredPhotons& stored) {
  readBytes(bytes, stored.onSurfaces);
  readBytes(bytes, stored.inMedia);
  readBytes(bytes, stored.beams);
}

template <class T> void moveTo(std::vector<T>& all, std::vector<T>& part) {
  all.insert(all.end(), part.begin(), part.end());
  std::vector<T>().swap(part);
}

} // namespace

ShotPhotons shootPhotons(const Scene& scene, const PathClasses& classes, const Pass& pass,
                         const ShootSettings& settings, const ForwardControl& control) {
  ShotPhotons shot;
  const bool dark = scene.lights().size() == 0 && !(settings.media && !settings.media->empty());
  if (dark || settings.photons == 0) return shot;
  const size_t batches = (settings.photons + BATCH - 1) / BATCH;
  std::vector<StoredPhotons> stored(batches);
  std::vector<TransportCounts> counts(batches);
  std::atomic<size_t> done{0};
  std::mutex telling;
  const auto shootBatch = [&](size_t b) {
    if (control.stopped()) return;
    PhotonWalk walk(scene, classes, settings, counts[b], stored[b]);
    const uint64_t end = std::min(settings.photons, (b + 1) * BATCH);
    for (uint64_t i = b * BATCH; i < end; ++i)
      walk.shoot(
          Sampler(hashCombine(pass.seed, pass.index), PHOTON_STREAM + (i >> 32), static_cast<uint32_t>(i)),
          pass.time);
    const size_t n = ++done;
    if (telling.try_lock()) {
      control.progress(static_cast<double>(n) / static_cast<double>(batches));
      telling.unlock();
    }
  };
  size_t total = 0;
  const auto shootBatches = [&](size_t first, size_t end) {
    parallelFor(end - first, [&](size_t i) { shootBatch(first + i); });
    for (size_t b = first; b < end; ++b) {
      total += stored[b].onSurfaces.size();
      shot.storedHere += stored[b].size();
    }
    shot.emittedHere += std::min(settings.photons, end * BATCH) - std::min(settings.photons, first * BATCH);
    const double expected = double(total) * double(settings.photons) / double(shot.emittedHere);
    requireMemory(formatted("a map of %.3g photons", expected), MAP_COPIES * sizeof(Photon) * expected);
  };
  if (control.sharing && batches > FIRST_BATCHES) {
    const bool isComplete = control.sharing->share(
        batches, shootBatches, [&](size_t b) { return packed(stored[b]); },
        [&](size_t b, std::span<const std::byte> bytes) { unpack(bytes, stored[b]); });
    if (!isComplete) return shot;
  } else {
    // The first batches tell how many photons will be stored.
    const size_t first = std::min(batches, FIRST_BATCHES);
    shootBatches(0, first);
    if (first < batches) shootBatches(first, batches);
  }
  total = 0;
  for (const StoredPhotons& s : stored) total += s.onSurfaces.size();
  shot.stored.reserve(total);
  for (StoredPhotons& s : stored) {
    moveTo(shot.stored, s.onSurfaces);
    moveTo(shot.inMedia, s.inMedia);
    moveTo(shot.beams, s.beams);
  }
  for (const TransportCounts& c : counts) shot.counts.add(c);
  shot.emitted = settings.photons;
  return shot;
}

namespace {

/** Spheres that cover what is seen, but for what would need wide ones or is hardly anything. */
std::vector<DxtranSphere> dxtranSpheresAround(const Scene& scene, std::vector<Vec3f> seen,
                                              std::span<const Vec3f> landed) {
  constexpr float WIDEST = 0.2f;     // of the scene
  constexpr double MIN_COUNT = 0.02; // of what is seen
  constexpr float SPARED = 8;        // as many photons as that are not needed
  constexpr size_t MAX_COUNT = 8;
  struct Part {
    std::span<Vec3f> places;
    Bounds3f box;
    float radius() const { return glm::length(box.diagonal()) / 2; }
  };
  const auto partOf = [](std::span<Vec3f> places) {
    Part part{places, {}};
    for (const Vec3f& p : places) part.box.add(p);
    return part;
  };
  std::vector<Part> parts{partOf(seen)};
  while (parts.size() < MAX_COUNT) {
    // The one is cut whose places would gain most.
    const auto cut = std::max_element(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
      return square(a.radius()) * static_cast<float>(a.places.size()) <
             square(b.radius()) * static_cast<float>(b.places.size());
    });
    const int axis = widestAxis(cut->box.diagonal());
    const float at = cut->box.center()[axis];
    const auto middle =
        std::partition(cut->places.begin(), cut->places.end(), [&](const Vec3f& p) { return p[axis] < at; });
    const auto left = static_cast<size_t>(middle - cut->places.begin());
    if (left == 0 || left == cut->places.size()) break;
    const Part right = partOf(cut->places.subspan(left));
    *cut = partOf(cut->places.first(left));
    parts.push_back(right);
  }
  std::vector<DxtranSphere> targets;
  for (const Part& part : parts) {
    const float radius = part.radius();
    const double share = double(part.places.size()) / double(seen.size());
    if (share < MIN_COUNT || !(radius > 0 && radius < WIDEST * scene.bounds().radius)) continue;
    const Vec3f center = part.box.center();
    // What a grey surface sends there, typically.
    std::vector<float> typical;
    for (const Vec3f& p : landed)
      if (const float q = square(radius) / lengthSquared(p - center); q < 1 / square(NEAR_TARGET))
        typical.push_back(0.5f * (1 - std::sqrt(1 - q)));
    if (typical.empty()) continue;
    const auto middle = typical.begin() + static_cast<std::ptrdiff_t>(typical.size() / 2);
    std::nth_element(typical.begin(), middle, typical.end());
    targets.push_back({center, radius, SPARED * *middle / static_cast<float>(share),
                       static_cast<float>(part.places.size()) / square(radius)});
  }
  return targets;
}

/** Trial photons, added up. */
struct Trials {
  std::vector<EmissionGuide::TrainingSample> useful;
  std::vector<float> powers; ///< of those in the region, in all that one photon emitted carries
  std::vector<Vec3f> landed; ///< a few of the places where photons were stored
  uint64_t stored = 0, inRegion = 0, sent = 0, arrived = 0;
  double squares = 0, guided = 0; ///< of what photons bring: without a guide, and with the one they had
  TransportCounts counts;
  /** Whether targets are worth the photons that are sent there. */
  bool arrive() const {
    constexpr double ENOUGH = 0.2;
    return double(arrived) >= ENOUGH * double(sent);
  }
  void add(const Trials& o) {
    useful.insert(useful.end(), o.useful.begin(), o.useful.end());
    landed.insert(landed.end(), o.landed.begin(), o.landed.end());
    powers.insert(powers.end(), o.powers.begin(), o.powers.end());
    stored += o.stored;
    inRegion += o.inRegion;
    sent += o.sent;
    arrived += o.arrived;
    squares += o.squares;
    guided += o.guided;
    counts.add(o.counts);
  }
};

/** What no photon should carry more than; not so little that splitting makes more photons than are emitted.
 */
float splitPowerOf(std::vector<float> powers, uint64_t emitted) {
  constexpr float OVER_TYPICAL = 2;
  if (powers.empty()) return INFINITE;
  const auto middle = powers.begin() + static_cast<std::ptrdiff_t>(powers.size() / 2);
  std::nth_element(powers.begin(), middle, powers.end());
  const double sum = std::accumulate(powers.begin(), powers.end(), 0.0);
  return std::max(OVER_TYPICAL * *middle, static_cast<float>(sum / double(emitted)));
}

Trials shootTrials(const Scene& scene, const PathClasses& classes, uint64_t seed,
                   const ShootSettings& settings, const VisibleRegion& region) {
  const size_t batches = (settings.photons + BATCH - 1) / BATCH;
  std::vector<Trials> parts(batches);
  parallelFor(batches, [&](size_t b) {
    Trials& part = parts[b];
    StoredPhotons stored;
    PhotonWalk walk(scene, classes, settings, part.counts, stored);
    walk.region = &region;
    for (uint64_t i = b * BATCH; i < std::min(settings.photons, (b + 1) * BATCH); ++i) {
      stored.clear();
      Sampler sampler(seed, TRIAL_STREAM, static_cast<uint32_t>(i));
      const float time =
          scene.moves() ? scene.camera().timeAt(sampler.next1D()) : 0; // the guide is for all times
      EmissionGuide::TrainingSample start = walk.shoot(sampler, time);
      // What is at full power in a target is a lot there, wherever it goes from now on.
      const double perPhoton = double(settings.photons) / double(start.weight);
      auto squares =
          double(walk.enteredImportance()) * square(double(walk.fullPower()) * double(settings.photons));
      for (const Photon& p : stored.onSurfaces) {
        const auto importance = double(region.importance(p.position));
        if (importance == 0) continue;
        ++part.inRegion;
        part.powers.push_back(maxComponent(p.power) * static_cast<float>(settings.photons));
        squares += importance * square(double(maxComponent(p.power)) * perPhoton);
      }
      // What is scattered evenly is seen by 1/4π of it, on a white surface by 1/π; errors go by the square.
      constexpr double BY_MEDIUM = 1.0 / 16;
      for (const VolumePhoton& p : stored.inMedia) {
        const auto importance = BY_MEDIUM * double(region.importanceInMedium(p.position));
        if (importance == 0) continue;
        ++part.inRegion;
        squares += importance * square(double(maxComponent(p.power)) * perPhoton);
      }
      part.stored += stored.size();
      if (!stored.onSurfaces.empty() && i % 16 == 0) part.landed.push_back(stored.onSurfaces[0].position);
      part.squares += double(start.weight) * squares;
      part.guided += square(double(start.weight)) * squares;
      start.weight *= static_cast<float>(squares);
      if (start.weight > 0) part.useful.push_back(start);
    }
    part.sent = walk.sent;
    part.arrived = walk.arrived;
  });
  Trials all;
  for (const Trials& t : parts) all.add(t);
  return all;
}

} // namespace

PhotonGuidance learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                             const ShootSettings& settings, const VisibleRegion& region,
                             const ForwardControl& control, TransportCounts& counts, bool targets) {
  constexpr uint64_t TRIALS = 8 * BATCH;
  constexpr int ROUNDS = 5, MAX_ROUNDS = 16;
  constexpr double RISES = 1.1, WORTH_IT = 1.5;
  constexpr double FEW = 0.05; // of photons in the region
  PhotonGuidance guidance;
  if (scene.lights().size() == 0 || region.empty()) return guidance;
  EmissionGuide& guide = guidance.emission;
  ShootSettings trial = settings;
  trial.guide = &guide;
  // No more than a pass has: learning must not cost many times what it serves.
  trial.photons = std::min(TRIALS, settings.photons);
  uint64_t shot = 0;
  double squares = 0, guided = 0; // of all rounds with a guide, each learned from those before
  // Returns the last round.
  const auto learn = [&] {
    guide = {};
    std::vector<EmissionGuide::TrainingSample> useful;
    for (int round = 1;; ++round) {
      const Trials trials = shootTrials(scene, classes, hashCombine(seed, shot++), trial, region);
      counts.add(trials.counts);
      if (shot == 1) guidance.useful = trials.inRegion;
      if (round > 1) squares += trials.squares;
      if (round > 1) guided += trials.guided;
      if (!trial.targets.empty() && !trials.arrive()) return trials;
      useful.insert(useful.end(), trials.useful.begin(), trials.useful.end());
      const double before = guide.gain();
      guide = EmissionGuide(useful, double(trial.photons) * round, scene.lights().size());
      // Few hits say little yet; many of a density that is good already, that there is no more to gain.
      double weight = 0, squared = 0;
      for (const EmissionGuide::TrainingSample& u : useful) {
        weight += double(u.weight);
        squared += square(double(u.weight));
      }
      const bool wellKnown = square(weight) > squared * double(trial.photons) / 4;
      if (control.stopped() || (wellKnown && guide.gain() < WORTH_IT) || round == MAX_ROUNDS ||
          (round >= ROUNDS && guide.gain() < RISES * before))
        return trials;
    }
  };
  Trials last = learn();
  if (targets && double(last.inRegion) < FEW * double(last.stored) && !control.stopped()) {
    const EmissionGuide without = guide;
    trial.targets = dxtranSpheresAround(scene, region.all(), last.landed);
    if (!trial.targets.empty()) {
      if (Trials sent = learn(); sent.arrive()) {
        last = std::move(sent);
      } else {
        trial.targets.clear();
        guide = without;
      }
    }
  }
  // What a few photons leave behind that media scatter hundreds of times tells less than it seems to.
  if (guide.gain() < WORTH_IT || (scene.hasMedia() && squares < guided)) guide = {};
  guidance.secondMoment = (guide.active() ? last.guided : last.squares) / double(trial.photons);
  guidance.targets = trial.targets;
  guidance.splitPower = splitPowerOf(std::move(last.powers), trial.photons);
  return guidance;
}

} // namespace recurse
