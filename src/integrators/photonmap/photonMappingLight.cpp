/** @file
 * Emitted light that a camera path of the photon mapping estimator hits, and shadow rays.
 */
#include "integrators/photonmap/photonMapping.h"
#include "transport/direct/directLight.h"

namespace recurse {

namespace {

/** Multiplies the weight of the next recorded contribution. */
void recordWeight(PathRadiance& out, float weight) {
  if (out.recorder) out.recorder->source.weight *= weight;
}

} // namespace

void PhotonMapping::addEmission(const Scene& scene, const PathState& path, const Hit* hit,
                                PathRadiance& out) const {
  const BsdfRay from = directWeights(path);
  forLightHits(scene, lights, hit, path.walk.ray, from, settings.lightSamples, nullptr, [&](LightHit found) {
    if (out.recorder) recordHit(*out.recorder, path.recordedStep, found, from);
    if (isShared(path)) return addShared(scene, path, found, out);
    if (path.nonDelta > 0 && path.delta && !settings.directLight) {
      const float weight = photons.rayWeight(scene, path.weights.merge, found);
      recordWeight(out, weight);
      found.weighted *= weight;
    }
    addLight(path, out.pathClasses().lightStart(found.index), found.weighted,
             path.walk.optical.at(found.beyond), out);
  });
}

void PhotonMapping::addShared(const Scene& scene, const PathState& path, const LightHit& found,
                              PathRadiance& out) const {
  const LightSampleContext& from = path.weights.bsdfRay.from;
  const LePdf pdf = photons.pdfLe(found.index, *found.light, found.emitted);
  const float distance = found.hit ? glm::distance(from.position, found.hit->point.position) : INFINITE;
  const float arrivals = photons.arrivals(scene, found.index, pdf, path.weights.shared.cosine, distance,
                                          lights.probability(scene.lights(), from, found.index));
  const float weight = path.weights.shared.share.camera(arrivals, path.weights.shared.pdf);
  recordWeight(out, weight);
  out.add(out.pathClasses().lightStart(found.index), path.walk.state,
          path.walk.throughput * found.weighted * (path.weights.shared.remainingWeight * weight),
          path.walk.optical.at(found.beyond));
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
