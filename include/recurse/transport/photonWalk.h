/** @file
 * The walk of one photon from its light, through surfaces and media, until it is killed.
 */
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "recurse/model/scatteringPoint.h"
#include "recurse/transport/directLight.h"
#include "recurse/transport/mergeWeights.h"
#include "recurse/transport/shoot.h"
#include "recurse/transport/walk.h"

namespace recurse {

/** Photons are shot in batches of so many. */
constexpr uint64_t PHOTON_BATCH = 4096;
/** Nearer than so many radii a target is too wide for a cone. */
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

/** Shoots photons, one after the other, and stores them where they may be found. */
class PhotonWalk {
 public:
  PhotonWalk(const Scene& scene, const PathClasses& classes, const ShootSettings& settings,
             TransportCounts& counts, StoredPhotons& out)
      : scene(scene), classes(classes), settings(settings), counts(counts), out(out), byMedia(partOfMedia()) {
  }

  /** Returns what the photon started by, and one over its density. */
  EmissionGuide::TrainingSample shoot(Sampler sampler, float time) {
    const float light = sampler.next1D(), part = sampler.next1D();
    const Vec2f place = sampler.next2D(), direction = sampler.next2D();
    EmissionGuide::TrainingSample start{{light, part, place.x, place.y, direction.x, direction.y}, 1};
    if (settings.guide && settings.guide->active())
      start.weight = 1 / settings.guide->warp(start.numbers, sampler.next1D());
    base = entered = 0;
    const bool fromMedium = byMedia > 0 && (byMedia >= 1 || sampler.next1D() < byMedia);
    storesDirect = settings.direct || fromMedium;
    std::optional<Flight> photon =
        fromMedium ? emitFromMedium(start, time, sampler) : emitFromLight(start, time, sampler);
    if (!photon) return start;
    walk(std::move(*photon), sampler);
    while (!waiting.empty()) {
      auto [flight, own] = waiting.back();
      waiting.pop_back();
      walk(std::move(flight), own);
    }
    return start;
  }
  /** Power of a photon that starts with weight 1, of the last one that was shot. */
  float fullPower() const { return base; }
  /** Of its start, if it came from infinitely far [1/length²]; else infinite. */
  float startDensity() const { return isInfinite(origin.kind) ? origin.pdf.position : INFINITE; }
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

  const LightTable& lights() const { return settings.lights ? *settings.lights : scene.lights(); }

  /** Of the photons, that glowing media emit: by power, but where there are lights too not nearly all. */
  float partOfMedia() const {
    constexpr double MOST = 0.9;
    if (!settings.media || settings.media->empty()) return 0;
    double byLights = 0;
    for (size_t i = 0; i < lights().size(); ++i) byLights += double(maxComponent(lights()[i].power()));
    if (!(byLights > 0)) return 1;
    const double byMedia = settings.media->power();
    return static_cast<float>(std::clamp(byMedia / (byMedia + byLights), 1 - MOST, MOST));
  }

  /** True where a photon of such a start is worth following; counts those that are not finite. */
  bool isUseful(const Rgb& flux) {
    if (!recurse::isFinite(flux)) {
      ++counts.nonFinite;
      return false;
    }
    return !isBlack(flux) && !classes.dead(classes.lightStart());
  }

  /** A photon of a glowing medium. */
  std::optional<Flight> emitFromMedium(const EmissionGuide::TrainingSample& start, float time,
                                       Sampler& sampler) {
    const auto& n = start.numbers;
    auto [position, nesting, power] = settings.media->sample(scene, time, n[0], {n[1], n[2], n[3]}, counts);
    const Rgb flux = power * (start.weight / byMedia / static_cast<float>(settings.photons));
    if (!isUseful(flux)) return {};
    const Ray ray{position, uniformSphere({n[4], n[5]}), INFINITE, time};
    Flight flight{ray, flux, classes.lightStart(), nesting, {}};
    flight.hero = std::min(2, static_cast<int>(3 * sampler.next1D()));
    return flight;
  }

  /** A photon of a light, which is chosen by power. */
  std::optional<Flight> emitFromLight(const EmissionGuide::TrainingSample& start, float time,
                                      Sampler& sampler) {
    const auto& n = start.numbers;
    float pick = n[0];
    const size_t index = lights().chooseIndex(pick);
    const Light& source = lights()[index];
    const float probability = lights().probability(index);
    if (!(probability > 0)) return {};
    const bool aimed = settings.aim && settings.aim->isAimed(static_cast<uint32_t>(index));
    const Vec2f towards{n[4], n[5]};
    std::optional<LeSample> emission =
        source.sampleLe({n[1], {n[2], n[3]}, aimed ? sampler.next2D() : towards, time});
    if (!emission) return {};
    if (aimed) settings.aim->redirect(source, *emission, pick, towards);
    if (isBlack(emission->flux)) return {};
    LePdf pdf = source.pdfLe(*emission);
    if (aimed) pdf.direction = emission->pdfDirection;
    if (source.isInfinite() && settings.portals && settings.portals->active()) {
      settings.portals->redirect(*emission, pick, {n[2], n[3]});
      pdf.position = emission->pdfPosition;
    }
    origin = {source.kind(), pdf, emission->origin, static_cast<uint32_t>(index), probability};
    Rgb flux = emission->flux / (probability * (1 - byMedia) * static_cast<float>(settings.photons));
    base = maxComponent(flux);
    if (source.isInfinite()) flux *= settings.fromFar;
    if (!isUseful(flux)) return {};
    const Ray ray{emission->origin, emission->direction, INFINITE, time};
    const ReverseRatio ratio =
        source.isMet() ? ReverseRatio::atLight(*emission, pdf, probability) : ReverseRatio();
    Flight flight{ray, flux * start.weight, classes.lightStart(), nestingAt(scene, ray, counts), ratio};
    if (scene.hasMedia()) {
      const uint16_t declared = source.isInfinite() ? settings.outside : scene.lightMedium(index);
      flight.nesting.startIn(declared ? declared : mediumAround(scene, ray, 0, counts));
      flight.hero = std::min(2, static_cast<int>(3 * sampler.next1D()));
    }
    return flight;
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
    if (settings.causticsOnly) return Through::ENDS;
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

  /** The BSDF of the next surface that scatters; null when the photon ends before. */
  const Bsdf* nextSurface(Flight& flight, Hit& hit, Sampler& sampler) {
    Ray& ray = flight.ray;
    for (;;) {
      const bool isHit = intersect(scene, ray, hit, counts);
      if (scene.hasMedia()) {
        if (isHit) flight.nesting.approach(hit, ray.direction);
        const Through through = flyInMedium(flight, isHit ? hit.t : INFINITE, sampler);
        if (through == Through::ENDS) return nullptr;
        if (through == Through::SCATTERS) continue;
      }
      if (!isHit) return nullptr;
      arena.reset();
      drawWavelength(scene, flight.wavelength, sampler, hit);
      const Bsdf* bsdf = bsdfAt(scene, hit, ray.direction, Footprint(), flight.nesting, arena);
      if (bsdf) return bsdf;
      flight.nesting.enterMedium(hit, ray.direction);
      if (scene.hasMedia())
        ray.origin = originBehind(ray, hit);
      else
        ray = spawn(hit.point, ray.direction);
    }
  }

  /** A surface where a photon has arrived. */
  struct Arrival {
    const Hit& hit;
    ScatteringPoint scattering;
    Vec3f wi; ///< unit, towards where the photon came from
    LightState afterD, afterS;
    LobeSet allowed = NO_LOBE; ///< lobes that the photon may leave by
    bool sends = false;        ///< photons to the targets, which BSDF sampling then leaves out
  };

  Arrival arrive(Flight& flight, const Hit& hit, const Bsdf& bsdf) const {
    flight.ratio.arrive(flight.ray.direction, hit.point);
    Arrival at{hit, ScatteringPoint(bsdf, hit.point), -flight.ray.direction,
               classes.step(flight.state, PathEvent::D), classes.step(flight.state, PathEvent::S)};
    const bool isForRays = flight.straight && startDensity() < settings.minStartDensity;
    const bool endsHere = classes.dead(at.afterD) || settings.causticsOnly || isForRays;
    at.allowed =
        LobeSet((endsHere ? NO_LOBE : NON_DELTA_LOBES) | (classes.dead(at.afterS) ? NO_LOBE : DELTA_LOBES));
    return at;
  }

  /** Sends a photon on from a surface by its BSDF and roulette. False when it ends there. */
  bool scatter(Flight& flight, const Arrival& at, Sampler& sampler) {
    const SurfacePoint& point = at.hit.point;
    const std::optional<Scatter> s = at.scattering.scatter(at.wi, Transport::FLUX, sampler, at.allowed);
    if (!s || (at.sends && !s->specular() && conesAround(s->direction) > 0)) return false;
    const Rgb scattered = flight.flux * s->weight;
    const float before = maxComponent(flight.flux), after = maxComponent(scattered);
    flight.flux = scattered;
    if (!russianRoulette(std::min(1.0f, after / before), flight.depth, sampler, flight.flux)) return false;
    flight.state = s->specular() ? at.afterS : at.afterD;
    flight.flux *= dispersedColour(point, *s, flight.wavelength);
    flight.nesting.scatters(at.hit, at.wi, s->direction);
    flight.caustic = flight.caustic && s->specular();
    flight.straight = flight.straight && passesPane(scene, at.scattering, *s);
    if (s->specular())
      flight.ratio.leave(s->direction, point);
    else
      flight.ratio = ratioAfter(flight.ratio, flight.depth - 1, at.hit, at.scattering, at.wi, s->direction);
    flight.ray = spawn(point, s->direction);
    return true;
  }

  /** Splits a strong photon into several, all but one of which wait. */
  void split(Flight& flight, const Arrival& at, Sampler& sampler) {
    constexpr uint32_t SPLIT = 2000; // not to be confused with others of the same sampler
    const int count = splitCount(flight.flux, at.hit.point.position);
    flight.flux /= static_cast<float>(count);
    for (int i = 1; i < count; ++i) {
      Flight copy = flight;
      Sampler own = sampler.fork(SPLIT + static_cast<uint32_t>(i));
      if (scatter(copy, at, own)) waiting.emplace_back(std::move(copy), own);
    }
  }

  /** Of trial photons: notes where one comes into a target straight from the light. */
  void noteTargetsEntered(const Vec3f& position) {
    for (const DxtranSphere& t : settings.targets)
      if (glm::distance(position, t.center) < t.radius) entered += t.importance;
  }

  /** Follows a photon until it is killed. */
  void walk(Flight flight, Sampler& sampler) {
    Hit hit;
    bool toTarget = flight.lowered < 1; // and has not come down yet
    while (const Bsdf* bsdf = nextSurface(flight, hit, sampler)) {
      if (flight.depth == settings.maxDepth) {
        counts.truncatedThroughput += double(maxComponent(flight.flux));
        return;
      }
      const Vec3f position = hit.point.position;
      if (region && flight.depth == 0) noteTargetsEntered(position);
      const bool outside = !settings.targets.empty() && findCones(position);
      if (std::exchange(toTarget, false) && region) arrived += region->contains(position);
      if (outside && flight.lowered < 1) {
        if (!russianRoulette(flight.lowered, flight.depth, sampler, flight.flux)) return;
        flight.lowered = 1;
      }
      Arrival at = arrive(flight, hit, *bsdf);
      const bool keepsPhotons = at.scattering.keepsPhotons();
      if (keepsPhotons && !classes.dead(at.afterD) && (!flight.straight || storesDirect)) store(flight, at);
      ++flight.depth;
      at.sends = outside && (at.allowed & NON_DELTA_LOBES) && (at.scattering.lobes() & LAMBERTIAN);
      if (at.sends) sendToTargets(flight, at, sampler);
      if (keepsPhotons) split(flight, at, sampler);
      if (!scatter(flight, at, sampler)) return;
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
  void sendToTargets(const Flight& from, const Arrival& at, const Sampler& sampler) {
    constexpr float MIN_COUNT = 0.01f, MAX_COUNT = 16;
    constexpr uint32_t BRANCH = 1000; // not to be confused with others of the same sampler
    const ScatteringPoint& scattering = at.scattering;
    const Vec3f& wi = at.wi;
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
        sentOut.state = at.afterD;
        sentOut.caustic = sentOut.straight = false;
        sentOut.ratio = ratioAfter(from.ratio, from.depth - 1, at.hit, scattering, wi, direction);
        sentOut.nesting.scatters(at.hit, wi, direction);
        sentOut.ray = spawn(at.hit.point, direction);
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

  void store(const Flight& flight, const Arrival& at) {
    const SurfacePoint& point = at.hit.point;
    const float geometric = absDot(at.wi, point.geometricNormal);
    if (geometric == 0) return; // in the plane of the surface: brings no flux
    Photon p;
    p.position = point.position;
    p.direction = packOnSide(at.wi, point.geometricNormal);
    p.normal = packDirection(point.normalTowards(at.wi));
    p.power = flight.flux * (absDot(at.wi, at.scattering.normal()) / geometric);
    p.pathState = flight.state.byte;
    p.caustic = flight.caustic;
    p.reverseRatio = flight.ratio.value();
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
  float byMedia = 0;        ///< the part of the photons that glowing media emit
  BsdfArena arena;
};

} // namespace recurse
