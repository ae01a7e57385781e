/** @file
 * Recurse's estimate of radiance: emitted light, plus the photon maps' estimate at non-delta surfaces, plus
 * mirror and refracted light, recursively. Direct light comes from shadow rays, or from photons like all
 * other light. In a progressive render the first non-delta surface of a path weighs the photons of indirect
 * light against the ray that it sends on.
 */
#include "integrators/photonmap/photonMappingIntegrator.h"

#include <algorithm>
#include <array>
#include <utility>

#include "recurse/core/threads/processorTime.h"
#include "transport/density/storedPhotons.h"

namespace recurse {

void PhotonMapping::prepare(const Scene& scene, const PathClasses&) {
  learned = {};
  if (&lights == &ownLights && !settings.directLight && settings.without != Mechanism::LIGHT_LEARNING)
    learned = ownLights.learn(scene, settings.without != Mechanism::SHADOW_OPENINGS);
}

ForwardStatistics PhotonMapping::forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                                         const ForwardControl& control) {
  ForwardStatistics statistics = photons.run(scene, classes, pass, control, lights);
  statistics.counts.add(std::exchange(learned, {}));
  recordSampler = Sampler(pass.seed, pass.index, 0);
  const bool oneClass = classes.lightStateCount() == 1; // with several, only some photons count
  const bool shared =
      settings.finalGather > 0 && settings.shareIrradiance && oneClass && !classes.isTransient();
  irradiances.reset(shared ? photons.indirect().cache().size() : 0);
  causticIrradiances.reset(shared ? photons.caustics().cache().size() : 0);
  return statistics;
}

void PhotonMapping::backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                             PathRadiance& out) const {
  PathState path;
  path.ray = ray;
  path.camera = out.pathClasses().cameraStart();
  path.nesting = nestingAt(scene, ray, out.counts);
  path.nesting.startIn(scene.cameraMedium());
  path.optical.index = indexAtStart(scene, out.pathClasses(), ray, path.nesting, out.counts);
  trace(scene, path, sampler, out);
}

bool hasMediaWithoutEnd(const Scene& scene) {
  if (!scene.hasEmissiveMedia()) return false;
  TransportCounts counts;
  const Medium* outside = scene.medium(mediumOutside(scene, counts));
  return outside && outside->isEmissive() && !(glm::length(outside->bounds().diagonal()) < INFINITE);
}

void PhotonMapping::trace(const Scene& scene, PathState path, Sampler& sampler, PathRadiance& out) const {
  BsdfArena arena;
  Hit hit;
  for (;;) {
    const bool isHit = intersect(scene, path.ray, hit, out.counts);
    if (scene.hasMedia() && isHit) path.nesting.approach(hit, path.ray.direction);
    if (scene.hasMedia() && !passMedium(scene, path, isHit ? hit.t : INFINITE, sampler, out)) return;
    if (!isHit) {
      addEnvironment(scene, path, out);
      return;
    }
    path.ray.width += path.ray.spread * hit.t;
    path.distance += hit.t;
    path.optical.travel(hit.t);
    if (hit.areaLight) addEmission(scene, path, hit, out);
    if (path.share == 0 && path.direct.merged == 0 && hit.material && !(hit.material->lobes() & DELTA_LOBES))
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
      out.counts.truncatedThroughput += double(maxComponent(path.sharedThroughput()));
      return;
    }
    ++path.depth;
    const ScatteringPoint scattering(*bsdf, hit.point);
    if (out.recorder)
      path.recordedVertex = out.recorder->addVertex(path.recordedStep, hit, path.ray.direction,
                                                    scattering.lobes(), path.sharedThroughput());
    if (scattering.hasNonDelta()) addNonDelta(scene, path, hit, scattering, sampler, out);
    if (!followDelta(scene, path, hit, scattering, sampler, out)) return;
  }
}

bool PhotonMapping::followDelta(const Scene& scene, PathState& path, const Hit& hit,
                                const ScatteringPoint& scattering, Sampler& sampler,
                                PathRadiance& out) const {
  const PathClasses& classes = out.pathClasses();
  path.camera = classes.step(path.camera, PathEvent::S, surfaceKind(classes, hit));
  if (!scattering.hasDelta() || classes.dead(path.camera)) return false;
  path.merge.arrive(path.ray.direction, hit.point);
  std::array<Scatter, DeltaScatters::MAX_COUNT> all;
  const int count = scattering.deltaScatters(-path.ray.direction, Transport::RADIANCE, all);
  float worth[DeltaScatters::MAX_COUNT], total = 0, least = INFINITE;
  const float scale = path.remainingWeight * path.etaScale;
  for (int i = 0; i < count; ++i) {
    const Scatter& s = all[size_t(i)];
    worth[i] = maxComponent(path.throughput * s.weight) * square(s.eta) * scale;
    total += worth[i];
    if (worth[i] > 0) least = std::min(least, worth[i]);
  }
  if (!(total > 0)) return false;
  int next = 0;
  // A branch under roulette may be the image of a light, which no other technique finds behind fog.
  if (path.nonDelta == 0 && least * path.mediaScale >= settings.weightLimit &&
      path.depth <= MAX_BRANCHING_DEPTH) {
    for (int i = 1; i < count; ++i) {
      Sampler branch = sampler.fork(static_cast<uint32_t>(i));
      const Scatter& s = all[size_t(i)];
      PathState next = path.after(hit, s, passesPane(scene, scattering, s));
      recordStep(scattering, -path.ray.direction, s, next, out);
      trace(scene, next, branch, out);
    }
  } else {
    float u = count > 1 ? sampler.next1D() * total : 0;
    while (next + 1 < count && u >= worth[next]) u -= worth[next++];
    if (!(worth[next] > 0)) return false;
    path.throughput *= total / worth[next];
    // Long walks use their full weight, which may need thousands of events to fall below the limit.
    const float chance = path.depth > MAX_BRANCHING_DEPTH ? total : total / settings.weightLimit;
    if (!russianRoulette(std::min(1.0f, chance), path.depth, sampler, path.throughput)) return false;
  }
  const Scatter& s = all[size_t(next)];
  const Vec3f wi = -path.ray.direction;
  path = path.after(hit, s, passesPane(scene, scattering, s));
  recordStep(scattering, wi, s, path, out);
  return true;
}

void PhotonMapping::addNonDelta(const Scene& scene, PathState path, const Hit& hit,
                                const ScatteringPoint& scattering, Sampler& sampler,
                                PathRadiance& out) const {
  if (!scattering.keepsPhotons()) {
    addByRays(scene, std::move(path), hit, scattering, sampler, out);
    return;
  }
  const PathClasses& classes = out.pathClasses();
  path.camera = classes.step(path.camera, PathEvent::D, surfaceKind(classes, hit));
  if (classes.dead(path.camera) || !goesOn(path, sampler)) return;
  const Vec3f wi = -path.ray.direction;
  PhotonShare direct = std::exchange(path.direct, {});
  direct.ratio.arrive(path.ray.direction, hit.point);
  direct.unknownWeight = std::exchange(path.share, 1);
  LightSampleContext context;
  if (!settings.directLight) {
    context = lightSampleContext(lights, hit.point, wi);
    addDirectLight(scene, path, context, direct, hit, scattering, sampler, out);
  }
  Rgb unshared = path.sharedThroughput();
  path.remainingWeight *= direct.unknownWeight;
  float merging = 0;
  PhotonQuery indirect;
  if (direct.unknownWeight > 0) {
    const PhotonLayer& caustics = photons.caustics();
    merging = addPhotons(scene, caustics, causticIrradiances,
                         photons.query(caustics, hit.point, wi, scattering.lobes()), scattering, hit.point,
                         path, sampler, out)
                  .merging;
    indirect = photons.query(photons.indirect(), hit.point, wi, scattering.lobes());
    weighIndirect(path, indirect);
    GatherSettings& gather = indirect.settings;
    if (gather.unknownWeight > 0 || gather.merging > 0) {
      const GatherResult used = addPhotons(scene, photons.indirect(), irradiances, indirect, scattering,
                                           hit.point, path, sampler, out);
      gather.merging = used.merging;
      gather.unknownWeight = used.unknownWeight;
    }
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
    recordStep(scattering, wi, *s, next, out);
    next.ray.width = next.ray.spread = 0; // the footprint is unknown from here on
    next.distance = 0;
    next.delta = next.panes = false;
    next.byRays = false;
    // Estimates at Lambertian surfaces use photons of all directions.
    next.lightShare = scattering.lobes() & LAMBERTIAN ? 0 : settings.weighting.followed(s->pdf);
    next.share = direct.unknownWeight > 0 ? 1 - indirect.settings.unknownWeight * (1 - next.lightShare) : 0;
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
    if (next.share > 0 || next.direct.merged > 0 || mayHitLight(scene)) trace(scene, next, branch, out);
  }
}

void PhotonMapping::addByRays(const Scene& scene, PathState path, const Hit& hit,
                              const ScatteringPoint& scattering, Sampler& sampler, PathRadiance& out) const {
  const PathClasses& classes = out.pathClasses();
  path.camera = classes.step(path.camera, PathEvent::D, surfaceKind(classes, hit));
  path.remainingWeight *= std::exchange(path.share, 1);
  path.direct = {};
  path.shared = {};
  if (classes.dead(path.camera) || !goesOn(path, sampler)) return;
  const Vec3f wi = -path.ray.direction;
  const LightSampleContext context = lightSampleContext(lights, hit.point, wi);
  addDirectLight(scene, path, context, {}, hit, scattering, sampler, out);
  Sampler branch = sampler.fork(DeltaScatters::MAX_COUNT + 2);
  const std::optional<Scatter> s = scattering.scatterNonDelta(wi, Transport::RADIANCE, branch);
  if (!s) return;
  ++path.nonDelta;
  PathState next = path.after(hit, *s);
  recordStep(scattering, wi, *s, next, out);
  next.ray.width = next.ray.spread = 0;
  next.distance = 0;
  next.delta = next.panes = false;
  next.lightShare = 1;
  next.byRays = true;
  next.bsdfRay = {context, s->pdf, true};
  next.merge = MergeRatio();
  trace(scene, next, branch, out);
}

void PhotonMapping::recordStep(const ScatteringPoint& scattering, const Vec3f& wi, const Scatter& s,
                               PathState& next, PathRadiance& out) {
  if (!out.recorder) return;
  const bool isDelta = s.specular();
  next.recordedStep =
      out.recorder->addStep({.vertex = next.recordedVertex,
                             .event = isDelta ? PathEvent::S : PathEvent::D,
                             .lobe = s.lobe,
                             .direction = s.direction,
                             .throughput = next.sharedThroughput(),
                             .pdf = isDelta ? 0 : s.pdf,
                             .pdfReverse = isDelta ? 0 : scattering.pdfNonDelta(s.direction, wi)});
}

void PhotonMapping::visitPhotons(const std::function<void(const StoredPhoton&)>& visit) const {
  visitMap(photons.caustics().map, true, visit);
  visitMap(photons.indirect().map, false, visit);
}

void PhotonMapping::visitPhotonBoxes(int levels, const std::function<void(const PhotonBox&)>& visit) const {
  visitMapBoxes(photons.caustics().map, true, levels, visit);
  visitMapBoxes(photons.indirect().map, false, levels, visit);
}

bool PhotonMapping::goesOn(PathState& path, Sampler& sampler) const {
  constexpr int FREE = 2; // number of non-delta surfaces that find most of the light
  const float worth = maxComponent(path.throughput) * path.etaScale * path.remainingWeight;
  const float chance = path.nonDelta >= FREE ? worth : worth / settings.weightLimit;
  return russianRoulette(std::min(1.0f, chance), path.depth, sampler, path.throughput);
}

std::unique_ptr<PhotonMapper> makePhotonMapping(const PhotonMappingSettings& settings,
                                                const LightSampler* lights) {
  return std::make_unique<PhotonMapping>(settings, lights);
}

} // namespace recurse
