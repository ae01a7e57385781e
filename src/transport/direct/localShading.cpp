/** @file
 * Direct light of a vertex, by a shadow ray and a BSDF ray.
 */
#include "transport/direct/localShading.h"

#include "transport/paths/walker.h"

namespace recurse {

namespace {

/** Adds the emission that a BSDF-sampled ray finds before its next scattering event. */
void addBsdfRay(const Scene& scene, const LightSampler& lights, const LightSampleContext& context,
                const CameraVertex& vertex, const Nesting& nesting, Sampler& sampler, PathRadiance& out) {
  const std::optional<Scatter> s =
      vertex.scattering->scatterNonDelta(vertex.wi, Transport::RADIANCE, sampler);
  if (!s || isBlack(vertex.throughput * s->weight)) return;
  const PathClasses& classes = out.pathClasses();
  CameraSubpath path;
  path.ray = spawn(vertex.point(), s->direction);
  path.nesting = nesting;
  path.nesting.scatters(vertex.hit, vertex.wi, s->direction);
  path.state = vertex.afterD;
  path.throughput = vertex.throughput * s->weight;
  int step = CAMERA_STEP;
  if (PathRecorder* recorder = out.recorder)
    step = recorder->addStep(
        recordedStep(recorder->source.vertex, *s, path.throughput, float(vertex.pdfReverse(s->direction))));
  CameraWalker walker(scene, classes, out.counts, -1);
  CameraVertex next;
  walker.next(path, next, sampler, [&](const Hit* hit) {
    addSeenEmission(scene, lights, path, hit, step, out, {context, s->pdf, true});
  });
}

} // namespace

void addDirectLight(const Scene& scene, const LightSampler& lights, const CameraVertex& vertex,
                    const Nesting& nesting, Sampler& sampler, PathRadiance& out) {
  const PathClasses& classes = out.pathClasses();
  if (!vertex.isConnectable() || scene.lights().size() == 0 || !classes.isLit(vertex.afterD, false)) return;
  const LightSampleContext context = lightSampleContext(lights, vertex.point(), vertex.wi);
  addSampledLight(scene, lights, context, *vertex.scattering, vertex.hit, nesting, vertex.wi,
                  vertex.throughput, vertex.afterD, 1, NON_DELTA_LOBES, 0, sampler, out);
  if (scene.contents().areaLights + scene.contents().environmentLights > 0)
    addBsdfRay(scene, lights, context, vertex, nesting, sampler, out);
}

void addSeenEmission(const Scene& scene, const LightSampler& lights, const CameraSubpath& path,
                     const Hit* hit, int step, PathRadiance& out, const BsdfRay& ray) {
  forLightHits(scene, lights, hit, path.ray, ray, 1, nullptr, [&](const LightHit& found) {
    if (out.recorder) recordHit(*out.recorder, step, found, ray);
    out.add(out.pathClasses().lightStart(found.index), path.state, path.throughput * found.weighted,
            path.optical.at(found.beyond));
  });
}

} // namespace recurse
