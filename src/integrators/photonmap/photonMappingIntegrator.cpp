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
  path.walk = startCameraSubpath(scene, out.pathClasses(), ray, out.counts);
  trace(scene, path, sampler, out);
}

bool hasMediaWithoutEnd(const Scene& scene) {
  if (!scene.hasEmissiveMedia()) return false;
  TransportCounts counts;
  const Medium* outside = scene.medium(mediumOutside(scene, counts));
  return outside && outside->isEmissive() && !(glm::length(outside->bounds().diagonal()) < INFINITE);
}

void PhotonMapping::trace(const Scene& scene, PathState path, Sampler& sampler, PathRadiance& out) const {
  CameraWalker walker(scene, out.pathClasses(), out.counts, -1, InMedia::PASS);
  CameraVertex vertex;
  const auto emission = [&](const Hit* hit) {
    if (hit)
      addEmission(scene, path, *hit, out);
    else
      addEnvironment(scene, path, out);
  };
  const auto flight = [&](uint16_t medium, float end) { passMedium(scene, path, medium, end, sampler, out); };
  for (;;) {
    path.walk.needed = path.share == 0 && path.direct.merged == 0 ? DELTA_LOBES : NO_LOBE;
    if (!walker.next(
            path.walk, vertex, sampler, emission, [](const Rgb&) {}, flight))
      return;
    if (settings.maxDepth >= 0 && path.walk.depth > settings.maxDepth) {
      out.counts.truncatedThroughput += double(maxComponent(path.sharedThroughput()));
      return;
    }
    path.distance += glm::distance(path.walk.from, vertex.point().position);
    if (out.recorder)
      path.recordedVertex = out.recorder->addVertex(path.recordedStep, vertex.hit, path.walk.ray.direction,
                                                    vertex.scattering->lobes(), path.sharedThroughput());
    if (vertex.scattering->hasNonDelta()) addNonDelta(scene, walker, path, vertex, sampler, out);
    if (!followDelta(scene, walker, path, vertex, sampler, out)) return;
  }
}

bool PhotonMapping::followDelta(const Scene& scene, const CameraWalker& walker, PathState& path,
                                const CameraVertex& vertex, Sampler& sampler, PathRadiance& out) const {
  const ScatteringPoint& scattering = *vertex.scattering;
  if (!scattering.hasDelta() || out.pathClasses().dead(vertex.afterS)) return false;
  path.merge.arrive(path.walk.ray.direction, vertex.point());
  std::array<Scatter, DeltaScatters::MAX_COUNT> all;
  const int count = scattering.deltaScatters(vertex.wi, Transport::RADIANCE, all);
  float worth[DeltaScatters::MAX_COUNT], total = 0, least = INFINITE;
  const float scale = path.remainingWeight * path.walk.etaScale;
  for (int i = 0; i < count; ++i) {
    const Scatter& s = all[size_t(i)];
    worth[i] = maxComponent(path.walk.throughput * s.weight) * square(s.eta) * scale;
    total += worth[i];
    if (worth[i] > 0) least = std::min(least, worth[i]);
  }
  if (!(total > 0)) return false;
  const auto after = [&](const Scatter& s) {
    PathState next = path.afterDelta(walker, vertex, s, passesPane(scene, scattering, s));
    recordStep(vertex, s, next, out);
    return next;
  };
  int next = 0;
  // A branch under roulette may be the image of a light, which no other technique finds behind fog.
  if (path.nonDelta == 0 && least * path.mediaScale >= settings.weightLimit &&
      path.walk.depth <= MAX_BRANCHING_DEPTH) {
    for (int i = 1; i < count; ++i) {
      Sampler branch = sampler.fork(static_cast<uint32_t>(i));
      trace(scene, after(all[size_t(i)]), branch, out);
    }
  } else {
    float u = count > 1 ? sampler.next1D() * total : 0;
    while (next + 1 < count && u >= worth[next]) u -= worth[next++];
    if (!(worth[next] > 0)) return false;
    path.walk.throughput *= total / worth[next];
    // Long walks use their full weight, which may need thousands of events to fall below the limit.
    const float chance = path.walk.depth > MAX_BRANCHING_DEPTH ? total : total / settings.weightLimit;
    if (!russianRoulette(std::min(1.0f, chance), path.walk.depth, sampler, path.walk.throughput))
      return false;
  }
  path = after(all[size_t(next)]);
  return true;
}

void PhotonMapping::addNonDelta(const Scene& scene, const CameraWalker& walker, PathState path,
                                const CameraVertex& vertex, Sampler& sampler, PathRadiance& out) const {
  const Hit& hit = vertex.hit;
  const ScatteringPoint& scattering = *vertex.scattering;
  if (!scattering.keepsPhotons()) {
    addByRays(scene, walker, std::move(path), vertex, sampler, out);
    return;
  }
  path.walk.state = vertex.afterD;
  if (out.pathClasses().dead(vertex.afterD) || !goesOn(path, sampler)) return;
  const Vec3f& wi = vertex.wi;
  PhotonShare direct = std::exchange(path.direct, {});
  direct.ratio.arrive(path.walk.ray.direction, hit.point);
  direct.unknownWeight = std::exchange(path.share, 1);
  LightSampleContext context;
  if (!settings.directLight) {
    context = lightSampleContext(lights, hit.point, wi);
    addDirectLight(scene, path, context, direct, vertex, sampler, out);
  }
  Rgb unshared = path.sharedThroughput();
  path.remainingWeight *= direct.unknownWeight;
  float merging = 0;
  PhotonQuery indirect;
  if (direct.unknownWeight > 0) {
    const PhotonLayer& caustics = photons.caustics();
    merging =
        addPhotons(scene, caustics, causticIrradiances,
                   photons.query(caustics, hit.point, wi, scattering.lobes()), vertex, path, sampler, out)
            .merging;
    indirect = photons.query(photons.indirect(), hit.point, wi, scattering.lobes());
    weighIndirect(path, indirect);
    GatherSettings& gather = indirect.settings;
    if (gather.unknownWeight > 0 || gather.merging > 0) {
      const GatherResult used =
          addPhotons(scene, photons.indirect(), irradiances, indirect, vertex, path, sampler, out);
      gather.merging = used.merging;
      gather.unknownWeight = used.unknownWeight;
    }
  }

  const int rays = path.nonDelta == 0 ? std::max(settings.finalGather, 1) : 1;
  path.walk.throughput /= static_cast<float>(rays);
  unshared /= static_cast<float>(rays);
  for (int i = 0; i < rays && !out.abandoned(); ++i) {
    Sampler branch = sampler.fork(DeltaScatters::MAX_COUNT + 2 + static_cast<uint32_t>(i));
    const std::optional<Scatter> s = scattering.scatterNonDelta(wi, Transport::RADIANCE, branch);
    if (!s) continue;
    PathState next = path.afterNonDelta(walker, vertex, *s);
    recordStep(vertex, *s, next, out);
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

void PhotonMapping::addByRays(const Scene& scene, const CameraWalker& walker, PathState path,
                              const CameraVertex& vertex, Sampler& sampler, PathRadiance& out) const {
  path.walk.state = vertex.afterD;
  path.remainingWeight *= std::exchange(path.share, 1);
  path.direct = {};
  path.shared = {};
  if (out.pathClasses().dead(vertex.afterD) || !goesOn(path, sampler)) return;
  const LightSampleContext context = lightSampleContext(lights, vertex.point(), vertex.wi);
  addDirectLight(scene, path, context, {}, vertex, sampler, out);
  Sampler branch = sampler.fork(DeltaScatters::MAX_COUNT + 2);
  const std::optional<Scatter> s = vertex.scattering->scatterNonDelta(vertex.wi, Transport::RADIANCE, branch);
  if (!s) return;
  PathState next = path.afterNonDelta(walker, vertex, *s);
  recordStep(vertex, *s, next, out);
  next.lightShare = 1;
  next.byRays = true;
  next.bsdfRay = {context, s->pdf, true};
  next.merge = MergeRatio();
  trace(scene, next, branch, out);
}

void PhotonMapping::recordStep(const CameraVertex& vertex, const Scatter& s, PathState& next,
                               PathRadiance& out) {
  if (!out.recorder) return;
  const bool isDelta = s.specular();
  next.recordedStep = out.recorder->addStep(
      {.vertex = next.recordedVertex,
       .event = isDelta ? PathEvent::S : PathEvent::D,
       .lobe = s.lobe,
       .direction = s.direction,
       .throughput = next.sharedThroughput(),
       .pdf = isDelta ? 0 : s.pdf,
       .pdfReverse = isDelta ? 0 : vertex.scattering->pdfNonDelta(s.direction, vertex.wi)});
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
  const float worth = maxComponent(path.walk.throughput) * path.walk.etaScale * path.remainingWeight;
  const float chance = path.nonDelta >= FREE ? worth : worth / settings.weightLimit;
  return russianRoulette(std::min(1.0f, chance), path.walk.depth, sampler, path.walk.throughput);
}

std::unique_ptr<PhotonMapper> makePhotonMapping(const PhotonMappingSettings& settings,
                                                const LightSampler* lights) {
  return std::make_unique<PhotonMapping>(settings, lights);
}

} // namespace recurse
