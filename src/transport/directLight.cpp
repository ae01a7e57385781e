/** @file
 * Shadow rays and their weights.
 */
#include "recurse/transport/directLight.h"

namespace recurse {

void addSampledLight(const Scene& scene, const LightSampler& guide, const LightSampleContext& place,
                     const ScatteringPoint& scattering, const Hit& hit, const Nesting& nesting,
                     const Vec3f& eye, const Rgb& throughput, CameraState cameraState, int samples,
                     LobeSet allowed, int maxPanes, Sampler& sampler, PathRadiance& out) {
  if (!lightIsSampled(scene, out.pathClasses(), cameraState)) return;
  for (int i = 0; i < samples && !out.abandoned(); ++i) {
    const SampledLight choice(scene.lights(), guide, place, sampler);
    const std::optional<LiSample> light = choice.sampleLi(hit.point);
    if (!light) continue;
    const Rgb radiance =
        unshadowedRadiance(scattering, eye, throughput, *light, choice.chosen.probability, samples, allowed);
    if (isBlack(radiance)) continue;
    const Transmittance free = transmittance(scene, hit, eye, *light, nesting, maxPanes, out.counts);
    if (!isBlack(free.value))
      out.add(afterPanes(out.pathClasses(), free.panes), cameraState, radiance * free.value);
  }
}

Rgb emittedRadiance(const Scene& scene, const LightSampler& guide, const Hit& hit, const Vec3f& direction,
                    const BsdfRay& ray, int lightSamples) {
  const Rgb radiance = hit.areaLight->radiance(hit.point, -direction);
  if (!ray.weighted || isBlack(radiance)) return radiance;
  const float lightPdf = guide.probability(scene.lights(), ray.from, hit.lightIndex) *
                         hit.areaLight->pdfLi(ray.from.position, hit.primitive, hit.point);
  return radiance * (1 - powerHeuristic(lightSamples, lightPdf, ray.pdf));
}

Rgb environmentRadiance(const Scene& scene, const LightSampler& guide, size_t which, const Vec3f& direction,
                        const BsdfRay& ray, int lightSamples) {
  const EnvironmentLight& light = *scene.environment()[which];
  const Rgb radiance = light.radiance(direction);
  if (!ray.weighted) return radiance;
  const float lightPdf = guide.probability(scene.lights(), ray.from, scene.environmentIndices()[which]) *
                         light.pdfLi(ray.from.position, direction);
  return radiance * (1 - powerHeuristic(lightSamples, lightPdf, ray.pdf));
}

Rgb environmentRadiance(const Scene& scene, const LightSampler& guide, const Vec3f& direction,
                        const BsdfRay& ray, int lightSamples) {
  Rgb sum = BLACK;
  for (size_t i = 0; i < scene.environment().size(); ++i)
    sum += environmentRadiance(scene, guide, i, direction, ray, lightSamples);
  return sum;
}

} // namespace recurse
