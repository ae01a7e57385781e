/** @file
 * Recurse's estimate of radiance: emitted light, plus the photon maps' estimate at non-delta surfaces, plus
 * mirror and refracted light, recursively. Direct light comes from shadow rays, or from photons like all
 * other light. In a progressive render the first non-delta surface of a path weighs the photons of indirect
 * light against the ray that it sends on.
 */
#include "integrators/photonmap/photonMapping.h"

#include <algorithm>
#include <array>
#include <utility>

#include "transport/density/storedPhotons.h"
#include "transport/paths/recordedSample.h"

namespace recurse {

ForwardStatistics PhotonMapping::forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                                         const ForwardControl& control) {
  ForwardStatistics statistics = photons.run(scene, classes, pass, control, lights);
  recordSampler = Sampler(pass.seed, pass.index, 0);
  const bool oneClass = classes.lightStateCount() == 1; // with several, only some photons count
  const bool shared = settings.finalGather > 0 && settings.shareIrradiance && oneClass &&
                      !classes.isTransient() && !scene.moves();
  irradiances.reset(shared ? photons.indirect().cache.size() : 0);
  causticIrradiances.reset(shared ? photons.caustics().cache.size() : 0);
  return statistics;
}

void PhotonMapping::backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                             PathRadiance& out) const {
  PathState path;
  path.walk = startCameraSubpath(scene, out.pathClasses(), ray, out.counts);
  trace(scene, path, sampler, out);
}

namespace {

/** Roulette of a camera path on arrival at a non-delta vertex. */
bool survives(PathState& path, Sampler& sampler) {
  return cameraRoulette(path.walk.etaScale, path.walk.depth, sampler, path.walk.throughput,
                        path.remainingWeight);
}

} // namespace

bool hasMediaWithoutEnd(const Scene& scene) {
  if (!scene.hasEmissiveMedia()) return false;
  TransportCounts counts;
  const Medium* outside = scene.medium(mediumOutside(scene, counts));
  return outside && outside->isEmissive() && !(glm::length(outside->bounds().diagonal()) < INFINITE);
}

bool mediaOnlyAbsorb(const Scene& scene) {
  for (size_t i = 1; i <= scene.mediumCount(); ++i) {
    const Medium& medium = *scene.medium(static_cast<uint16_t>(i));
    if (!medium.isHomogeneous() || medium.isEmissive() || !isBlack(medium.at(Vec3f(0)).scattering))
      return false;
  }
  return true;
}

void PhotonMapping::trace(const Scene& scene, PathState path, Sampler& sampler, PathRadiance& out) const {
  CameraWalker walker(scene, out.pathClasses(), out.counts, -1, InMedia::PASS);
  CameraVertex vertex;
  const auto emission = [&](const Hit* hit) { addEmission(scene, path, hit, out); };
  const auto flight = [&](uint16_t medium, float end) { passMedium(scene, path, medium, end, sampler, out); };
  for (;;) {
    path.walk.needed = path.weights.share == 0 && path.weights.direct.merged == 0 ? DELTA_LOBES : NO_LOBE;
    if (!walker.next(path.walk, vertex, sampler, emission, Ignore(), flight)) return;
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
  path.weights.merge.arrive(path.walk.ray.direction, vertex.point());
  // Maximum number of events after which a path splits. In a stack of panes every branch passes all panes
  // again.
  constexpr int MAX_SPLITTING_DEPTH = 8;
  std::array<Scatter, DeltaScatters::MAX_COUNT> all;
  const int count = scattering.deltaScatters(vertex.wi, Transport::RADIANCE, all);
  float weights[DeltaScatters::MAX_COUNT], total = 0, least = INFINITE;
  const float scale = path.remainingWeight * path.walk.etaScale;
  for (int i = 0; i < count; ++i) {
    const Scatter& s = all[size_t(i)];
    weights[i] = maxComponent(path.walk.throughput * s.weight) * square(s.eta) * scale;
    total += weights[i];
    if (weights[i] > 0) least = std::min(least, weights[i]);
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
      path.walk.depth <= MAX_SPLITTING_DEPTH) {
    for (int i = 1; i < count; ++i) {
      Sampler branch = sampler.fork(static_cast<uint32_t>(i));
      trace(scene, after(all[size_t(i)]), branch, out);
    }
  } else {
    float u = count > 1 ? sampler.next1D() * total : 0;
    while (next + 1 < count && u >= weights[next]) u -= weights[next++];
    if (!(weights[next] > 0)) return false;
    path.walk.throughput *= total / weights[next];
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
  VertexEstimates at;
  at.byRays = !vertex.scattering->keepsPhotons();
  path.walk.state = vertex.afterD;
  if (at.byRays) {
    path.remainingWeight *= std::exchange(path.weights.share, 1);
    path.weights.direct = {};
    at.indirect.unknownWeight = 0;
  }
  if (out.pathClasses().dead(vertex.afterD) || !survives(path, sampler)) return;
  at.direct = std::exchange(path.weights.direct, {});
  at.direct.ratio.arrive(path.walk.ray.direction, vertex.point());
  at.direct.unknownWeight = std::exchange(path.weights.share, 1);
  if (!settings.directLight || at.byRays) {
    at.context = lightSampleContext(lights, vertex.point(), vertex.wi);
    addDirectLight(scene, path, at.context, at.direct, vertex, sampler, out);
  }
  at.directWeight = path.remainingWeight;
  path.remainingWeight *= at.direct.unknownWeight;
  if (at.direct.unknownWeight > 0 && !at.byRays) addFromMaps(scene, path, vertex, sampler, at, out);

  const int rays = path.nonDelta == 0 && !at.byRays ? std::max(settings.finalGather, 1) : 1;
  path.walk.throughput /= static_cast<float>(rays);
  for (int i = 0; i < rays && !out.abandoned(); ++i)
    followNonDelta(scene, walker, path, vertex, at,
                   sampler.fork(DeltaScatters::MAX_COUNT + 2 + static_cast<uint32_t>(i)), out);
}

void PhotonMapping::addFromMaps(const Scene& scene, const PathState& path, const CameraVertex& vertex,
                                const Sampler& sampler, VertexEstimates& at, PathRadiance& out) const {
  const auto query = [&](const PhotonLayer& layer) {
    return photons.query(layer, vertex.point(), vertex.wi);
  };
  PhotonQuery caustics = query(photons.caustics()), indirect;
  if (!settings.causticsOnly) indirect = query(photons.indirect());
  caustics.settings.expected = caustics.expected + indirect.expected;
  at.causticMergeDensity =
      addPhotons(scene, photons.caustics(), causticIrradiances, caustics, vertex, path, sampler, out)
          .mergeDensity;
  if (settings.causticsOnly) {
    at.indirect.unknownWeight = 0;
    return;
  }
  weighIndirect(path, indirect);
  const GatherSettings& gather = indirect.settings;
  at.weighsIndirect = gather.weighedAgainstRays;
  at.indirect.mergeDensity = gather.mergeDensity;
  at.indirect.unknownWeight = gather.unknownWeight;
  if (gather.unknownWeight > 0 || gather.mergeDensity > 0)
    at.indirect = addPhotons(scene, photons.indirect(), irradiances, indirect, vertex, path, sampler, out);
}

void PhotonMapping::followNonDelta(const Scene& scene, const CameraWalker& walker, const PathState& path,
                                   const CameraVertex& vertex, const VertexEstimates& at, Sampler sampler,
                                   PathRadiance& out) const {
  const ScatteringPoint& scattering = *vertex.scattering;
  const std::optional<Scatter> s = scattering.scatterNonDelta(vertex.wi, Transport::RADIANCE, sampler);
  if (!s) return;
  PathState next = path.afterNonDelta(walker, vertex, *s);
  recordStep(vertex, *s, next, out);
  RayWeights& weights = next.weights = {};
  weights.byRays = at.byRays;
  // Estimates at Lambertian surfaces use photons of all directions.
  weights.lightShare = at.byRays                         ? 1
                       : scattering.lobes() & LAMBERTIAN ? 0
                                                         : settings.weighting.followed(s->pdf);
  weights.share = at.direct.unknownWeight > 0 ? 1 - at.indirect.unknownWeight * (1 - weights.lightShare) : 0;
  if (at.weighsIndirect)
    weights.direct = {1 - weights.lightShare,
                      MergeRatio(at.indirect.mergeDensity, s->pdf, s->direction, vertex.point())};
  if (at.direct.merged > 0)
    weights.shared = {at.direct, at.directWeight, scattering.pdfNonDelta(s->direction, vertex.wi),
                      absDot(s->direction, vertex.point().geometricNormal)};
  if (!settings.directLight || at.byRays) weights.bsdfRay = {at.context, s->pdf, true};
  weights.merge = MergeRatio(at.causticMergeDensity, s->pdf, s->direction, vertex.point());
  if (weights.share > 0 || weights.direct.merged > 0 || mayHitLight(scene)) trace(scene, next, sampler, out);
}

void PhotonMapping::recordStep(const CameraVertex& vertex, const Scatter& s, PathState& next,
                               PathRadiance& out) {
  if (!out.recorder) return;
  next.recordedStep =
      out.recorder->addStep(recordedStep(next.recordedVertex, s, next.sharedThroughput(),
                                         vertex.scattering->pdfNonDelta(s.direction, vertex.wi)));
}

void PhotonMapping::visitPhotons(const std::function<void(const StoredPhoton&)>& visit) const {
  visitMap(photons.caustics().map, true, visit);
  visitMap(photons.indirect().map, false, visit);
}

void PhotonMapping::visitPhotonBoxes(int levels, const std::function<void(const PhotonBox&)>& visit) const {
  visitMapBoxes(photons.caustics().map, true, levels, visit);
  visitMapBoxes(photons.indirect().map, false, levels, visit);
}

} // namespace recurse
