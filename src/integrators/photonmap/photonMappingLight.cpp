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

void PhotonMapping::addEmission(const Scene& scene, const PathState& path, const Hit* hit,
                                PathRadiance& out) const {
  const BsdfRay from = directWeights(path);
  forLightHits(scene, lights, hit, path.walk.ray, from, settings.lightSamples, nullptr, [&](LightHit found) {
    if (out.recorder) recordHit(*out.recorder, path.recordedStep, found, from);
    if (path.nonDelta > 0 && path.delta && !settings.directLight) {
      const float weight = photons.rayWeight(scene, path.weights.merge, found);
      recordWeight(out, weight);
      found.weighted *= weight;
    }
    addLight(path, out.pathClasses().lightStart(found.index), found.weighted,
             path.walk.optical.at(found.beyond), out);
  });
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
                                   const LightSampleContext& context, const CameraVertex& vertex,
                                   Sampler& sampler, PathRadiance& out) const {
  addSampledLight(scene, lights, context, *vertex.scattering, vertex.hit, path.walk.nesting, vertex.wi,
                  path.sharedThroughput(), path.walk.state, settings.lightSamples, NON_DELTA_LOBES,
                  panesLeft(settings.maxDepth, path.walk.depth), sampler, out, path.walk.optical);
}

} // namespace recurse
