/** @file
 * Emitted light that a camera path of the photon mapping estimator hits, and shadow rays.
 */
#include "integrators/photonmap/photonMapping.h"
#include "transport/direct/recordedLight.h"

namespace recurse {

namespace {

/** Multiplies the weight of the next recorded contribution. */
void recordWeight(PathRadiance& out, float weight) {
  if (out.recorder) out.recorder->source.weight *= weight;
}

} // namespace

void PhotonMapping::addEmission(const Scene& scene, const PathState& path, const Hit& hit,
                                PathRadiance& out) const {
  const Vec3f& direction = path.walk.ray.direction;
  Rgb radiance = emittedRadiance(scene, lights, hit, direction, directWeights(path), settings.lightSamples);
  if (isBlack(radiance)) return;
  if (out.recorder)
    recordHit(*out.recorder, path.recordedStep, scene, lights, hit, direction, directWeights(path),
              settings.lightSamples, radiance);
  if (isShared(path)) {
    const LePdf pdf = photons.pdfLe(
        hit.lightIndex, *hit.areaLight,
        {hit.point.position, -direction, hit.point.geometricNormal, hit.primitive, hit.point.time});
    addShared(scene, path, hit.lightIndex, pdf, radiance,
              glm::distance(path.weights.bsdfRay.from.position, hit.point.position), path.walk.optical.length,
              out);
    return;
  }
  if (path.nonDelta > 0 && path.delta && !settings.directLight) {
    const float weight = photons.rayWeight(scene, path.weights.merge, hit, direction);
    recordWeight(out, weight);
    radiance *= weight;
  }
  addLight(path, out.pathClasses().lightStart(hit.lightIndex), radiance, path.walk.optical.length, out);
}

void PhotonMapping::addEnvironment(const Scene& scene, const PathState& path, PathRadiance& out) const {
  if (scene.environment().empty()) return;
  const Vec3f& direction = path.walk.ray.direction;
  const float length = path.walk.optical.at(lengthFromInfinity(scene, path.walk.ray.origin, direction));
  for (size_t i = 0; i < scene.environment().size(); ++i) {
    Rgb radiance =
        environmentRadiance(scene, lights, i, direction, directWeights(path), settings.lightSamples);
    if (isBlack(radiance)) continue;
    if (out.recorder)
      recordHit(*out.recorder, path.recordedStep, scene, lights, i, direction, directWeights(path),
                settings.lightSamples, radiance);
    if (isShared(path)) {
      const EnvironmentLight& light = *scene.environment()[i];
      const uint32_t index = scene.environmentIndices()[i];
      const LePdf pdf = photons.pdfLe(index, light, {path.walk.ray.origin, -direction, Vec3f(0), 0});
      addShared(scene, path, index, pdf, radiance, INFINITE, length, out);
      continue;
    }
    if (path.nonDelta > 0 && path.delta && !settings.directLight) {
      const float weight = photons.rayWeight(scene, path.weights.merge, i, path.walk.ray);
      recordWeight(out, weight);
      radiance *= weight;
    }
    addLight(path, out.pathClasses().lightStart(scene.environmentIndices()[i]), radiance, length, out);
  }
}

void PhotonMapping::addShared(const Scene& scene, const PathState& path, uint32_t light, const LePdf& pdf,
                              const Rgb& radiance, float distance, float length, PathRadiance& out) const {
  const LightSampleContext& from = path.weights.bsdfRay.from;
  const float arrivals = photons.arrivals(scene, light, pdf, path.weights.shared.cosine, distance,
                                          lights.probability(scene.lights(), from, light));
  const float weight = path.weights.shared.share.camera(arrivals, path.weights.shared.pdf);
  recordWeight(out, weight);
  out.add(out.pathClasses().lightStart(light), path.walk.state,
          path.walk.throughput * radiance * (path.weights.shared.remainingWeight * weight), length);
}

void PhotonMapping::addLight(const PathState& path, LightState light, const Rgb& radiance, float length,
                             PathRadiance& out) const {
  const float share = settings.directLight ? path.weights.lightShare : 1;
  if (!(share > 0) || isBlack(radiance)) return;
  recordWeight(out, share);
  const Rgb added = path.sharedThroughput() * radiance * share;
  if (path.nonDelta == 0)
    out.addSeen(light, path.walk.state, added, length);
  else
    out.add(light, path.walk.state, added, length);
}

void PhotonMapping::addDirectLight(const Scene& scene, const PathState& path,
                                   const LightSampleContext& context, const PhotonShare& share,
                                   const CameraVertex& vertex, Sampler& sampler, PathRadiance& out) const {
  const Hit& hit = vertex.hit;
  const ScatteringPoint& scattering = *vertex.scattering;
  const auto add = [&](const Rgb& throughput, const ShadowRayWeight& weight) {
    addSampledLight(scene, lights, context, scattering, hit, path.walk.nesting, vertex.wi, throughput,
                    path.walk.state, settings.lightSamples, NON_DELTA_LOBES,
                    panesLeft(settings.maxDepth, path.walk.depth), sampler, out, path.walk.optical, weight);
  };
  if (share.merged == 0) {
    add(path.sharedThroughput() * share.unknownWeight, {});
    return;
  }
  add(path.sharedThroughput(), [&](const ChosenLight& chosen, const LiSample& light, int panes) {
    if (panes > 0) return share.unknownWeight;
    const LePdf pdf = photons.pdfLe(chosen.index, *chosen.light, light.emitted());
    const float cosine = absDot(light.direction, hit.point.geometricNormal);
    return share.camera(
        photons.arrivals(scene, chosen.index, pdf, cosine, light.distance, chosen.probability),
        scattering.pdfNonDelta(light.direction, vertex.wi));
  });
}

} // namespace recurse
