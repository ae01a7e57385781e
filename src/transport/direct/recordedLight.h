/** @file
 * Recording of light hits by a PathRecorder.
 */
#pragma once

#include "recurse/transport/integrator/pathRecorder.h"
#include "transport/direct/directLight.h"

namespace recurse {

/** Sets the source of a contribution: a ray that left by `step` hit an area light. `lightSamples`: number of
 * shadow rays that compete with it. `weighted`: its radiance times the MIS weight. */
inline void recordHit(PathRecorder& recorder, int step, const Scene& scene, const LightSampler& lights,
                      const Hit& hit, const Vec3f& direction, const BsdfRay& ray, int lightSamples,
                      const Rgb& weighted) {
  RecordedSource& s = recorder.source;
  s = {.technique = PathTechnique::HIT, .vertex = s.vertex, .step = step, .end = hit.point.position};
  s.weight = recorded::weightOf(weighted, hit.areaLight->radiance(hit.point, -direction));
  if (!ray.weighted) return;
  s.pdf = ray.pdf;
  s.otherPdf = static_cast<float>(lightSamples) *
               lights.probability(scene.lights(), ray.from, hit.lightIndex) *
               hit.areaLight->pdfLi(ray.from.position, hit.primitive, hit.point);
}

/** Sets the source for a ray of unit `direction` that left the scene, and one of its environment lights. */
inline void recordHit(PathRecorder& recorder, int step, const Scene& scene, const LightSampler& lights,
                      size_t which, const Vec3f& direction, const BsdfRay& ray, int lightSamples,
                      const Rgb& weighted) {
  RecordedSource& s = recorder.source;
  s = {.technique = PathTechnique::HIT, .vertex = s.vertex, .step = step, .end = direction};
  s.isInfinite = true;
  const EnvironmentLight& light = *scene.environment()[which];
  s.weight = recorded::weightOf(weighted, light.radiance(direction));
  if (!ray.weighted) return;
  s.pdf = ray.pdf;
  s.otherPdf = static_cast<float>(lightSamples) *
               lights.probability(scene.lights(), ray.from, scene.environmentIndices()[which]) *
               lights.pdfLi(light, ray.from.position, direction);
}

} // namespace recurse
