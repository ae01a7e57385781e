/** @file
 * Recurse's estimate of radiance: emitted light, plus the photon maps' estimate at non-delta surfaces, plus
 * mirror and refracted light, recursively. Direct light comes from shadow rays, or from photons like all
 * other light. In a progressive render the first non-delta surface of a path weighs the photons of indirect
 * light against the ray that it sends on.
 */
#include "recurse/transport/photonMapping.h"

#include <algorithm>
#include <utility>

#include "recurse/core/text.h"
#include "recurse/model/plugIns.h"
#include "recurse/transport/directLight.h"
#include "recurse/transport/estimatorTrial.h"
#include "recurse/transport/irradianceCache.h"
#include "recurse/transport/lightAlongRay.h"
#include "recurse/transport/mergeWeights.h"

namespace recurse {

namespace {

/** Light that comes straight to a surface is shared with photons that are merged at the surface before. */
struct PhotonShare {
  float merged = 0; ///< the part of it that the weights of mergeWeights.h apply to
  MergeRatio ratio; ///< up to the surface
  float rest = 1;   ///< the camera's part where no weight is known

  /** The camera's part; `pdf`: of photons that the surface sends back along the path [1/sr]. */
  float camera(float arrivals, float pdf) const {
    if (merged == 0 || !std::isfinite(arrivals)) return rest;
    return 1 - merged + merged * ratio.cameraWeight(arrivals, pdf);
  }
};

/** A ray that may meet such light. */
struct SharedRay {
  PhotonShare share;
  Rgb throughput{0}; ///< without the share
  float pdf = 0;     ///< see PhotonShare::camera
  float cosine = 0;  ///< at the surface
};

/** A camera path on its way. */
struct PathState {
  CameraRay ray;
  CameraState camera;
  Nesting nesting;
  Rgb throughput{1};
  float etaScale = 1;   ///< undoes the 1/η² inside glass
  int depth = 0;        ///< scattering events so far
  int nonDelta = 0;     ///< those by non-delta lobes
  float wavelength = 0; ///< as in Subpath
  // Since the last of these:
  float distance = 0;   ///< travelled [scene units]
  bool delta = false;   ///< by mirrors and glass, thin panes apart
  bool panes = false;   ///< through thin panes, where shadow rays go too
  bool byRays = true;   ///< no photons are kept there: it is the camera, or on a curve
  float share = 1;      ///< of the indirect light there that is for this path to find
  PhotonShare direct;   ///< the same of the direct light there
  SharedRay shared;     ///< of light that is met at once
  BsdfRay bsdfRay;      ///< weighs light that is met at once against shadow rays
  MergeRatio merge;     ///< weighs light that is met by mirrors and glass against caustic photons
  float lightShare = 1; ///< of emission that is met, where photons bring all light

  /** The path after a scattering event; `pane`: it went straight through a thin pane. */
  PathState after(const Hit& hit, const Scatter& s, bool pane = false) const {
    PathState next = *this;
    next.nesting.scatters(hit, -ray.direction, s.direction);
    next.throughput *= s.weight;
    next.throughput *= dispersedColour(hit.point, s, next.wavelength);
    next.etaScale *= square(s.eta);
    static_cast<Ray&>(next.ray) = spawn(hit.point, s.direction);
    if (s.specular()) {
      (pane ? next.panes : next.delta) = true;
      next.merge.leave(s.direction, hit.point);
    }
    return next;
  }
};

class PhotonMapping final : public Integrator {
 public:
  explicit PhotonMapping(const PhotonMappingSettings& settings) : settings(settings), photons(settings) {}

  int passes(int /*samplesPerPixel*/) const override { return settings.passes; }

  uint64_t photonsEmitted(const Scene& scene) const override {
    return photons.photonCount(scene, settings.passes != 1);
  }

  bool passHasOneTime() const override { return true; }

  void prepare(const Scene& scene, const PathClasses&) override {
    learned = {};
    if (!settings.directLight) learned = lights.learn(scene);
  }

  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override {
    if (pass.index == 0)
      pathTracer.reset();
    else if (pathTracer)
      return {};
    ForwardStatistics statistics = photons.run(scene, classes, pass, control, lights);
    statistics.counts.add(std::exchange(learned, {}));
    if (pass.index == 0 && mayLeaveItToPaths(scene)) tryPaths(scene, classes, pass, control, statistics);
    recordSampler = Sampler(pass.seed, pass.index, 0);
    const bool oneClass = classes.lightStateCount() == 1; // else some photons count and some do not
    const bool shared = settings.finalGather > 0 && settings.shareIrradiance && oneClass;
    irradiances.reset(shared ? photons.indirect().cache.size() : 0);
    causticIrradiances.reset(shared ? photons.caustics().cache.size() : 0);
    return statistics;
  }

  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    if (pathTracer) {
      pathTracer->backward(scene, ray, sampler, out);
      return;
    }
    PathState path;
    path.ray = ray;
    path.camera = out.pathClasses().cameraStart();
    path.nesting = nestingAt(scene, ray, out.counts);
    path.nesting.startIn(scene.cameraMedium());
    trace(scene, path, sampler, out);
  }

  void backwardBatch(const Scene& scene, std::span<CameraPath> paths) const override {
    if (pathTracer)
      pathTracer->backwardBatch(scene, paths);
    else
      Integrator::backwardBatch(scene, paths);
  }

  std::vector<EstimatorDomain> domains() const override;

  /** Photons cannot start in a medium without end. */
  bool supportsMedia(const Scene& scene) const override {
    bool emits = false;
    for (uint16_t i = 1; i <= scene.mediumCount(); ++i) emits = emits || scene.medium(i)->isEmissive();
    if (!emits) return true;
    TransportCounts counts;
    const Medium* outside = scene.medium(mediumOutside(scene, counts));
    return !outside || !outside->isEmissive() || glm::length(outside->bounds().diagonal()) < INFINITE;
  }

 private:
  /** Whether paths decide by themselves where to read the map of indirect light. */
  bool mayGoOn() const { return settings.finalGather < 0 && photons.isProgressive(); }

  // ------------------------------------------------------------------------------------- photons or paths

  /** Whether path tracing finds all light that photons do, and a trial is little work beside the picture. */
  bool mayLeaveItToPaths(const Scene& scene) const {
    constexpr int MAX_LIGHT_SAMPLES = 64; // with more, a trial may take longer than the picture
    if (settings.lightSamples > MAX_LIGHT_SAMPLES) return false;
    if (!settings.trial || !mayGoOn() || settings.nearest > 0 || settings.radius > 0 || settings.directLight)
      return false;
    bool met = true; // by rays, as lamps far away hardly are
    for (uint32_t i = 0; i < scene.lights().size(); ++i)
      met = met && scene.lights()[i].isMet() && !photons.isAimed(i);
    return scene.lights().size() > 0 && (met || photons.caustics().map.empty()) &&
           scene.film().whole().area() >= EstimatorTrial::PIXELS;
  }

  /** Leaves the picture to path tracing where a few blocks of it tell that photons are not worth their work.
   */
  void tryPaths(const Scene& scene, const PathClasses& classes, const Pass& pass,
                const ForwardControl& control, ForwardStatistics& statistics) {
    constexpr uint64_t STREAM = 0x747269616cull;
    constexpr double PASS_RAY = 2; // to shoot, store and sort, over a ray of a camera path
    const Pass other{hashCombine(pass.seed, STREAM), 1, false, pass.time};
    const EstimatorTrial trial(scene, classes, other.seed, pass.time);
    Diagnostics diagnostics;
    std::unique_ptr<Integrator> tracer = plugIns().integrators.make(
        parseParameterText("path", formatted("\"integer maxdepth\" %d \"integer lightsamples\" %d",
                                             settings.maxDepth, settings.lightSamples)),
        {}, diagnostics);
    tracer->prepare(scene, classes);
    statistics.counts.add(tracer->forward(scene, classes, pass, control).counts);
    EstimatorTrial::Rounds traced{trial.take(*tracer, 0), trial.take(*tracer, 1)}, mapped;
    mapped[0] = trial.take(*this, 0);
    const ForwardStatistics shot =
        photons.with(other, scene, classes, control, lights, [&] { mapped[1] = trial.take(*this, 1); });
    for (const EstimatorTrial::Rounds* rounds : {&traced, &mapped})
      for (const TrialSamples& samples : *rounds) statistics.counts.add(samples.counts);
    statistics.counts.add(shot.counts);
    if (control.stopped()) return;
    EstimatorTrial::Figures byMap = EstimatorTrial::figures(mapped, traced),
                            byPaths = EstimatorTrial::figures(traced, mapped);
    byMap.work += PASS_RAY * double(shot.counts.rays) / double(scene.film().whole().area());
    byPaths.add(photons.causticVarianceByRays() + EstimatorTrial::missedVariance(traced, mapped));
    const double ratio = byMap.errorOver(byPaths);
    constexpr double CLEARLY = 2; // a trial misses rare bright samples, of which paths have more
    if (!(ratio > CLEARLY)) return;
    statistics.notes.push_back(formatted("photons: the picture is left to path tracing, which by a trial has "
                                         "1/%.2g of the squared error for the "
                                         "same work (\"bool trial\" false: photons anyway)",
                                         ratio));
    pathTracer = std::move(tracer);
  }

  /** Follows a path to the end: emitted light, and at each surface what its lobes bring. */
  void trace(const Scene& scene, PathState path, Sampler& sampler, PathRadiance& out) const {
    BsdfArena arena;
    Hit hit;
    for (;;) {
      const bool met = intersect(scene, path.ray, hit, out.counts);
      if (scene.hasMedia() && met) path.nesting.approach(hit, path.ray.direction);
      if (scene.hasMedia() && !passMedium(scene, path, met ? hit.t : INFINITE, sampler, out)) return;
      if (!met) {
        addEnvironment(scene, path, out);
        return;
      }
      path.ray.width += path.ray.spread * hit.t;
      path.distance += hit.t;
      if (hit.areaLight) addEmission(scene, path, hit, out);
      if (path.share == 0 && path.direct.merged == 0 && hit.material &&
          !(hit.material->lobes() & DELTA_LOBES))
        return;
      arena.reset();
      drawWavelength(scene, path.wavelength, sampler, hit);
      const Bsdf* bsdf = bsdfAt(scene, hit, path.ray.direction, footprint(path.ray), path.nesting, arena);
      if (!bsdf) {
        path.nesting.enterMedium(hit, path.ray.direction);
        if (scene.hasMedia())
          path.ray.origin = originBehind(path.ray, hit);
        else
          static_cast<Ray&>(path.ray) = spawn(hit.point, path.ray.direction);
        continue;
      }
      if (path.depth == settings.maxDepth) {
        out.counts.truncatedThroughput += double(maxComponent(path.throughput));
        return;
      }
      ++path.depth;
      const ScatteringPoint scattering(*bsdf, hit.point);
      if (scattering.hasNonDelta()) addNonDelta(scene, path, hit, scattering, sampler, out);
      if (!followDelta(scene, path, hit, scattering, sampler, out)) return;
    }
  }

  // ------------------------------------------------------------------------------------------------- media

  /** Light that the medium on the way to `end` sends along the path, and what it takes off. False where
   * nothing is left. */
  bool passMedium(const Scene& scene, PathState& path, float end, Sampler& sampler, PathRadiance& out) const {
    const uint16_t number = path.nesting.medium(scene);
    const Medium* medium = scene.medium(number);
    if (!medium) return true;
    const RayTransmittance transmittance(*medium, path.ray, end, sampler);
    // Photons bring what media emit to where they are kept.
    if (path.byRays || settings.directLight) addLight(path, transmittance.emitted(), out);
    if (path.depth != settings.maxDepth) addScattering(scene, path, number, end, transmittance, sampler, out);
    path.throughput *= transmittance.to(end);
    return !isBlack(path.throughput);
  }

  static constexpr uint32_t HERO = 64; ///< tells its number from those of branches

  /** Light that the medium scatters once more: direct by a shadow ray, other by photons along the way. */
  void addScattering(const Scene& scene, const PathState& path, uint16_t number, float end,
                     const RayTransmittance& transmittance, Sampler& sampler, PathRadiance& out) const {
    const CameraState camera = out.pathClasses().step(path.camera, PathEvent::V);
    const Rgb throughput = path.throughput * path.share;
    if (out.pathClasses().dead(camera) || isBlack(throughput)) return;
    const Medium& medium = *scene.medium(number);
    const Vec3f& direction = path.ray.direction;
    addPhotonsAlong(path, number, medium, end, transmittance, throughput, camera, out);
    if (settings.directLight) return;
    const int hero = std::min(2, static_cast<int>(3 * sampler.fork(HERO).next1D()));
    const int panes = panesLeft(settings.maxDepth, path.depth + 1);
    const auto vertex = [&](const Hit& hit, const SpectralPath& spectral) {
      return LitVertex{hit,          nullptr,  &medium, -direction, NON_DELTA_LOBES,
                       path.nesting, spectral, hero,    camera,     false};
    };
    Hit hit;
    if (!medium.isHomogeneous()) {
      SpectralPath spectral{throughput};
      const Collision c = flyThrough(medium, path.ray, end, hero, sampler, spectral, [](const Rgb&) {});
      if (!c.scatters || isBlack(spectral.throughput)) return;
      hit.point = pointInMedium(path.ray, c.t);
      addSampledLightInMedia(scene, lights, {hit.point.position}, vertex(hit, spectral),
                             settings.lightSamples, panes, sampler, out);
      return;
    }
    const Rgb scattering = medium.at(path.ray.origin).scattering;
    if (isBlack(scattering) || !lightIsSampled(scene, out.pathClasses(), camera)) return;
    for (int i = 0; i < settings.lightSamples && !out.abandoned(); ++i) {
      const std::optional<LightAlongRay> s = sampleLightAlong(scene, lights, medium, path.ray, end, sampler);
      if (!s) continue;
      hit.point = pointInMedium(path.ray, s->t);
      const SpectralPath spectral{throughput * transmittance.to(s->t) * scattering};
      addLightInMedia(scene, vertex(hit, spectral), s->light,
                      static_cast<float>(settings.lightSamples) / s->reciprocalPdf, panes, sampler, out);
    }
  }

  /** Light that photons in the medium bring along the path. */
  void addPhotonsAlong(const PathState& path, uint16_t number, const Medium& medium, float end,
                       const RayTransmittance& transmittance, const Rgb& throughput, CameraState camera,
                       PathRadiance& out) const {
    const auto add = [&](const Vec3f& flight, const Rgb& scattered, float t, uint8_t pathState) {
      const float f = medium.phase->value(-glm::dot(flight, path.ray.direction));
      ++out.counts.photonsFound;
      out.add(LightState(pathState), camera, throughput * transmittance.to(t) * scattered * f);
    };
    const MediaPhotons& inMedia = photons.inMedia();
    inMedia.points.visitAlong(path.ray, end, [&](const VolumePhoton& p, float t, float kernel) {
      if (p.medium == number) add(unpackDirection(p.direction), p.power * kernel, t, p.pathState);
    });
    if (inMedia.beams.size() == 0 || !medium.isHomogeneous()) return;
    const MediumPoint point = medium.at(path.ray.origin);
    const Rgb extinction = point.extinction(), relative = extinction - thinnest(extinction);
    inMedia.beams.visitAlong(path.ray, end, [&](const PhotonBeam& b, float s, float t, float kernel) {
      if (b.medium == number)
        add(b.direction, b.power * flight::transmittance(relative, s) * point.scattering * kernel, t,
            b.pathState);
    });
  }

  // ------------------------------------------------------------------------------------------ emitted light

  void addEmission(const Scene& scene, const PathState& path, const Hit& hit, PathRadiance& out) const {
    const Vec3f& direction = path.ray.direction;
    Rgb radiance = emittedRadiance(scene, lights, hit, direction, directWeights(path), settings.lightSamples);
    if (isBlack(radiance)) return;
    const auto pdf = [&] {
      return photons.pdfLe(
          hit.lightIndex, *hit.areaLight,
          {hit.point.position, -direction, hit.point.geometricNormal, hit.primitive, hit.point.time});
    };
    if (isShared(path)) {
      addShared(scene, path, hit.lightIndex, pdf(), radiance,
                glm::distance(path.bsdfRay.from.position, hit.point.position), out);
      return;
    }
    if (path.nonDelta > 0 && path.delta && !settings.directLight) {
      MergeRatio merge = path.merge;
      merge.arrive(direction, hit.point);
      radiance *= merge.cameraWeight(pdf(), photons.probability(scene, hit.lightIndex));
    }
    addLight(path, radiance, out);
  }

  void addEnvironment(const Scene& scene, const PathState& path, PathRadiance& out) const {
    if (scene.environment().empty()) return;
    const Vec3f& direction = path.ray.direction;
    for (size_t i = 0; i < scene.environment().size(); ++i) {
      const Rgb radiance =
          environmentRadiance(scene, lights, i, direction, directWeights(path), settings.lightSamples);
      if (isBlack(radiance)) continue;
      const uint32_t index = scene.environmentIndices()[i];
      const auto pdf = [&] {
        return photons.pdfLe(index, *scene.environment()[i], {path.ray.origin, -direction, Vec3f(0), 0});
      };
      if (isShared(path))
        addShared(scene, path, index, pdf(), radiance, INFINITE, out);
      else if (path.nonDelta > 0 && path.delta && !settings.directLight)
        addLight(path, radiance * path.merge.cameraWeight(pdf(), photons.probability(scene, index)), out);
      else
        addLight(path, radiance, out);
    }
  }

  /** Whether light that is met at once is shared with photons. */
  static bool isShared(const PathState& path) {
    return path.shared.share.merged > 0 && !path.delta && !path.panes;
  }

  void addShared(const Scene& scene, const PathState& path, uint32_t light, const LePdf& pdf,
                 const Rgb& radiance, float distance, PathRadiance& out) const {
    const LightSampleContext& from = path.bsdfRay.from;
    const float arrivals = photons.arrivals(scene, light, pdf, path.shared.cosine, distance,
                                            lights.probability(scene.lights(), from, light));
    out.add(out.pathClasses().lightStart(), path.camera,
            path.shared.throughput * radiance * path.shared.share.camera(arrivals, path.shared.pdf));
  }

  /** What light that is met shares with shadow rays: nothing from the camera on or after mirrors and glass.
   */
  BsdfRay directWeights(const PathState& path) const {
    return path.nonDelta == 0 || path.delta ? BsdfRay() : path.bsdfRay;
  }

  void addLight(const PathState& path, const Rgb& radiance, PathRadiance& out) const {
    const float share = settings.directLight ? path.lightShare : 1;
    if (!(share > 0) || isBlack(radiance)) return;
    if (path.nonDelta == 0)
      out.addSeen(path.camera, path.throughput * radiance * share);
    else
      out.add(out.pathClasses().lightStart(), path.camera, path.throughput * radiance * share);
  }

  // ---------------------------------------------------------------------------------------- mirrors, glass

  /** Goes on by the delta lobes: every branch of a path from the camera while it is worth it, one by roulette
   * after. False where the path ends. */
  bool followDelta(const Scene& scene, PathState& path, const Hit& hit, const ScatteringPoint& scattering,
                   Sampler& sampler, PathRadiance& out) const {
    path.camera = out.pathClasses().step(path.camera, PathEvent::S);
    if (!scattering.hasDelta() || out.pathClasses().dead(path.camera)) return false;
    path.merge.arrive(path.ray.direction, hit.point);
    std::array<Scatter, DeltaScatters::MAX_COUNT> all;
    const int count = scattering.deltaScatters(-path.ray.direction, Transport::RADIANCE, all);
    float worth[DeltaScatters::MAX_COUNT], total = 0, least = INFINITE;
    for (int i = 0; i < count; ++i) {
      const Scatter& s = all[size_t(i)];
      worth[i] = maxComponent(path.throughput * s.weight) * square(s.eta) * path.etaScale;
      total += worth[i];
      if (worth[i] > 0) least = std::min(least, worth[i]);
    }
    if (!(total > 0)) return false;
    int next = 0;
    if (path.nonDelta == 0 && least >= settings.weightLimit && path.depth <= LONG_WALK) {
      for (int i = 1; i < count; ++i) {
        Sampler branch = sampler.fork(static_cast<uint32_t>(i));
        const Scatter& s = all[size_t(i)];
        trace(scene, path.after(hit, s, passesPane(scene, scattering, s)), branch, out);
      }
    } else {
      float u = count > 1 ? sampler.next1D() * total : 0;
      while (next + 1 < count && u >= worth[next]) u -= worth[next++];
      if (!(worth[next] > 0)) return false;
      path.throughput *= total / worth[next];
      // A long walk by its full weight: it may be thousands of events from falling below the limit.
      const float chance = path.depth > LONG_WALK ? total : total / settings.weightLimit;
      if (!russianRoulette(std::min(1.0f, chance), path.depth, sampler, path.throughput)) return false;
    }
    const Scatter& s = all[size_t(next)];
    path = path.after(hit, s, passesPane(scene, scattering, s));
    return true;
  }

  // -------------------------------------------------------------------------------------- non-delta lobes

  /** The same where no photons are kept: by shadow rays, and by a ray that finds all other light. */
  void addByRays(const Scene& scene, PathState path, const Hit& hit, const ScatteringPoint& scattering,
                 Sampler& sampler, PathRadiance& out) const {
    path.camera = out.pathClasses().step(path.camera, PathEvent::D);
    path.throughput *= std::exchange(path.share, 1);
    path.direct = {};
    path.shared = {};
    if (out.pathClasses().dead(path.camera) || !goesOn(path, sampler)) return;
    const Vec3f wi = -path.ray.direction;
    const LightSampleContext context = lightSampleContext(lights, hit.point, wi);
    addDirectLight(scene, path, context, {}, hit, scattering, sampler, out);
    Sampler branch = sampler.fork(DeltaScatters::MAX_COUNT + 2);
    const std::optional<Scatter> s = scattering.scatterNonDelta(wi, Transport::RADIANCE, branch);
    if (!s) return;
    ++path.nonDelta;
    PathState next = path.after(hit, *s);
    next.ray.width = next.ray.spread = 0;
    next.distance = 0;
    next.delta = next.panes = false;
    next.lightShare = 1;
    next.byRays = true;
    next.bsdfRay = {context, s->pdf, true};
    next.merge = MergeRatio();
    trace(scene, next, branch, out);
  }

  /** Light that non-delta lobes send along the path: direct, by photons, and by a ray that goes on. */
  void addNonDelta(const Scene& scene, PathState path, const Hit& hit, const ScatteringPoint& scattering,
                   Sampler& sampler, PathRadiance& out) const {
    if (!scattering.keepsPhotons()) {
      addByRays(scene, std::move(path), hit, scattering, sampler, out);
      return;
    }
    path.camera = out.pathClasses().step(path.camera, PathEvent::D);
    if (out.pathClasses().dead(path.camera) || !goesOn(path, sampler)) return;
    const Vec3f wi = -path.ray.direction;
    PhotonShare direct = std::exchange(path.direct, {});
    direct.ratio.arrive(path.ray.direction, hit.point);
    direct.rest = std::exchange(path.share, 1);
    LightSampleContext context;
    if (!settings.directLight) {
      context = lightSampleContext(lights, hit.point, wi);
      addDirectLight(scene, path, context, direct, hit, scattering, sampler, out);
    }
    Rgb unshared = path.throughput;
    path.throughput *= direct.rest;
    float merging = 0;
    PhotonQuery indirect;
    if (direct.rest > 0) {
      const PhotonLayer& caustics = photons.caustics();
      merging = addPhotons(scene, caustics, causticIrradiances,
                           photons.query(caustics, hit.point, wi, scattering.lobes()), scattering, hit.point,
                           path, sampler, out);
      indirect = photons.query(photons.indirect(), hit.point, wi, scattering.lobes());
      weighIndirect(path, indirect);
      const GatherSettings& gather = indirect.settings;
      indirect.settings.merging = gather.rest > 0 || gather.merging > 0
                                      ? addPhotons(scene, photons.indirect(), irradiances, indirect,
                                                   scattering, hit.point, path, sampler, out)
                                      : 0;
    }

    const int rays = path.nonDelta == 0 ? std::max(settings.finalGather, 1) : 1;
    ++path.nonDelta;
    path.throughput /= static_cast<float>(rays);
    unshared /= static_cast<float>(rays);
    for (int i = 0; i < rays && !out.abandoned(); ++i) {
      Sampler branch = sampler.fork(DeltaScatters::MAX_COUNT + 2 + static_cast<uint32_t>(i));
      const std::optional<Scatter> s = scattering.scatterNonDelta(wi, Transport::RADIANCE, branch);
      if (!s) continue;
      PathState next = path.after(hit, *s);
      next.ray.width = next.ray.spread = 0; // what a pixel sees from here on is not known
      next.distance = 0;
      next.delta = next.panes = false;
      next.byRays = false;
      // Photons around a Lambertian surface are all added up.
      next.lightShare = scattering.lobes() & LAMBERTIAN ? 0 : settings.weighting.followed(s->pdf);
      next.share = direct.rest > 0 ? 1 - indirect.settings.rest * (1 - next.lightShare) : 0;
      if (indirect.settings.weighedAgainstRays && !scene.hasMedia())
        next.direct = {1 - next.lightShare,
                       MergeRatio(indirect.settings.merging, s->pdf, s->direction, hit.point)};
      if (direct.merged == 0)
        next.shared = {};
      else
        next.shared = {direct, unshared * s->weight, scattering.pdfNonDelta(s->direction, wi),
                       absDot(s->direction, hit.point.geometricNormal)};
      next.bsdfRay = settings.directLight ? BsdfRay() : BsdfRay{context, s->pdf, true};
      next.merge = MergeRatio(merging, s->pdf, s->direction, hit.point);
      if (next.share > 0 || next.direct.merged > 0 || mayMeetLight(scene)) trace(scene, next, branch, out);
    }
  }

  /** Shadow rays. Photons may share what comes to the point through no pane. */
  void addDirectLight(const Scene& scene, const PathState& path, const LightSampleContext& context,
                      const PhotonShare& share, const Hit& hit, const ScatteringPoint& scattering,
                      Sampler& sampler, PathRadiance& out) const {
    const Vec3f wi = -path.ray.direction;
    const int panes = panesLeft(settings.maxDepth, path.depth);
    if (share.merged == 0) {
      addSampledLight(scene, lights, context, scattering, hit, path.nesting, wi, path.throughput * share.rest,
                      path.camera, settings.lightSamples, NON_DELTA_LOBES, panes, sampler, out);
      return;
    }
    if (!lightIsSampled(scene, out.pathClasses(), path.camera)) return;
    for (int i = 0; i < settings.lightSamples && !out.abandoned(); ++i) {
      const SampledLight choice(scene.lights(), lights, context, sampler);
      const std::optional<LiSample> light = choice.sampleLi(hit.point);
      if (!light) continue;
      Rgb radiance = unshadowedRadiance(scattering, wi, path.throughput, *light, choice.chosen.probability,
                                        settings.lightSamples, NON_DELTA_LOBES);
      if (isBlack(radiance)) continue;
      const Transmittance free = transmittance(scene, hit, wi, *light, path.nesting, panes, out.counts);
      if (isBlack(free.value)) continue;
      radiance *= free.panes > 0
                      ? share.rest
                      : share.camera(photons.arrivals(scene, choice.chosen.index,
                                                      photons.pdfLe(choice.chosen.index, *choice.chosen.light,
                                                                    light->emitted()),
                                                      absDot(light->direction, hit.point.geometricNormal),
                                                      light->distance, choice.chosen.probability),
                                     scattering.pdfNonDelta(light->direction, wi));
      out.add(afterPanes(out.pathClasses(), free.panes), path.camera, radiance * free.value);
    }
  }

  /** Roulette at a non-delta surface, with the part of the light that is left to the path. */
  bool goesOn(PathState& path, Sampler& sampler) const {
    constexpr int FREE = 2; // surfaces before which most of the light is found
    const float worth = maxComponent(path.throughput) * path.etaScale;
    const float chance = path.nonDelta >= FREE ? worth : worth / settings.weightLimit;
    return russianRoulette(std::min(1.0f, chance), path.depth, sampler, path.throughput);
  }

  bool mayMeetLight(const Scene& scene) const {
    return !settings.directLight && scene.contents().areaLights + scene.contents().environmentLights > 0;
  }

  /** What part of the indirect light at the end of the path is read from the map. */
  void weighIndirect(const PathState& path, PhotonQuery& query) const {
    GatherSettings& gather = query.settings;
    if (path.nonDelta == 0 && mayGoOn() && settings.nearest == 0 && settings.radius == 0 &&
        !settings.directLight) {
      photons.weighAgainstRays(query, path.ray.width);
      return;
    }
    if (mayGoOn() && photons.useless()) {
      gather.rest = 0;
    } else if (path.nonDelta == 0) {
      gather.rest = settings.finalGather > 0 ? 0 : 1;
    } else {
      // A map that is blurred over more than the distance is not to be seen by a surface close by.
      const float blur = photons.isProgressive() ? gather.radius : photons.indirect().choice.typicalRadius;
      gather.rest = path.distance < blur || !photons.paysInstead(query) ? 0 : 1;
    }
  }

  // ---------------------------------------------------------------------------------------------- photons

  /** Adds what photons of a layer bring at a point. Returns their weight against rays that find the same
   * light. */
  float addPhotons(const Scene& scene, const PhotonLayer& layer, const IrradianceCache& cache,
                   const PhotonQuery& query, const ScatteringPoint& scattering, const SurfacePoint& point,
                   const PathState& path, const Sampler& sampler, PathRadiance& out) const {
    const Vec3f wi = -path.ray.direction;
    if (hasRecord(cache, query, scattering, point, path)) {
      const GatherSettings search = atRecord(layer, query);
      const Rgb e = cache.at(query.place.index, out.counts, [&](TransportCounts& counts) {
        const RadiusCache::Place& place = layer.cache.place(query.place.index);
        BoundaryCorrection boundary{scene, recordSampler.fork(static_cast<uint32_t>(query.place.index)),
                                    &place.around};
        return irradiance(layer.map, search, place.position, place.normal, place.error,
                          settings.edges ? &boundary : nullptr, counts);
      });
      if (!isBlack(e))
        out.add(LightState(0), path.camera,
                path.throughput * e * scattering.value(wi, point.normalTowards(wi)));
      return mergingWithin(search.merging, square(search.radius));
    }
    BoundaryCorrection boundary{scene, sampler.fork(DeltaScatters::MAX_COUNT + 1), query.place.known,
                                query.place.away};
    return gather(layer.map, query.settings, scattering, point, wi, path.ray.width * photons.scale(),
                  path.throughput, path.camera, out, settings.edges ? &boundary : nullptr)
        .merging;
  }

  /** Whether many rays ask for the irradiance at the record near by, and the photons' directions make no
   * difference. */
  bool hasRecord(const IrradianceCache& cache, const PhotonQuery& query, const ScatteringPoint& scattering,
                 const SurfacePoint& point, const PathState& path) const {
    constexpr float NEAR = 0.5f; // of the radius
    const CachedRadius& near = query.place;
    return cache.size() > 0 && path.nonDelta > 0 && near.known &&
           near.away <= NEAR * photons.scale() * near.radius && (scattering.lobes() & LAMBERTIAN) &&
           !(scattering.lobes() & TRANSMISSION) && point.shadingNormal == point.geometricNormal;
  }

  /** How photons are searched at the record itself. */
  GatherSettings atRecord(const PhotonLayer& layer, const PhotonQuery& query) const {
    GatherSettings search = photons.searchWithin(layer, layer.cache.place(query.place.index).radius);
    search.weighedAgainstRays = query.settings.weighedAgainstRays;
    search.merging = query.settings.merging;
    search.rest = query.settings.rest;
    return search;
  }

  PhotonMappingSettings settings;
  PhotonPass photons;
  LightSampler lights;
  std::unique_ptr<Integrator> pathTracer; ///< renders in the place of all else; null: photons pay
  TransportCounts learned;                ///< what that took, until it has been told
  /** At the records of the layers, of this pass; empty where no rays go on. */
  IrradianceCache irradiances, causticIrradiances;
  Sampler recordSampler{0, 0, 0};
};

std::vector<EstimatorDomain> PhotonMapping::domains() const {
  const std::string each = "one for each non-delta surface a path meets";
  std::vector<EstimatorDomain> all = {
      {"emission", "LS*E", "none: met by rays through mirrors and glass", "", true}};
  const std::string caustics = settings.directLight ? "LS*DS*E" : "LS+DS*E",
                    indirect = "L(S|D|V)*(D|V)S*DS*E";
  if (!settings.directLight) {
    all.push_back({"shadow rays", "LDS*E",
                   std::to_string(settings.lightSamples) + " for each non-delta surface a path meets",
                   "direct light"});
    all.push_back({"BSDF rays", "LDS*E", each, "direct light", true});
    all.push_back({"shadow rays through panes", "LS+DS*E", "none: the same, straight through thin panes",
                   "caustics", false, true});
    all.push_back({"photons of media that glow", "LDS*E", each, "direct light"});
    all.push_back({"shadow rays in media", "LVS*E",
                   std::to_string(settings.lightSamples) + " for each part of a path in a medium",
                   "direct light in media"});
    all.push_back({"shadow rays in media through panes", "LS+VS*E",
                   "none: the same, straight through thin panes", "light in media", false, true});
    all.push_back({"photons in media of media that glow", "LVS*E",
                   "one estimate for each part of a path in a medium", "direct light in media"});
  }
  all.push_back({"photons in media", settings.directLight ? "L(S|D|V)*VS*E" : "L(S|D|V)+VS*E",
                 "one estimate for each part of a path in a medium",
                 settings.directLight ? "" : "light in media"});
  const bool rays = !settings.directLight || settings.weighting.ever();
  all.push_back({"caustic photons", caustics, "one estimate for each non-delta surface a path meets",
                 rays ? "caustics" : ""});
  if (rays)
    all.push_back({"BSDF rays by mirrors and glass", caustics, "none: the BSDF rays", "caustics", true});
  const bool reads = settings.finalGather <= 0;
  const bool goOn = !reads || settings.weighting.ever() || (settings.finalGather < 0 && settings.passes != 1);
  const char* group = reads && goOn ? "indirect light" : "";
  if (reads) all.push_back({"photon map", indirect, "one estimate for the first non-delta surface", group});
  if (goOn)
    all.push_back(
        {"paths that go on", indirect,
         (reads ? "one" : std::to_string(settings.finalGather)) +
             std::string(" from the first non-delta surface; what arrives is estimated by all of these"),
         group});
  return all;
}

} // namespace

std::unique_ptr<Integrator> makePhotonMapping(const PhotonMappingSettings& settings) {
  return std::make_unique<PhotonMapping>(settings);
}

} // namespace recurse
