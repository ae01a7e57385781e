/** @file
 * Shadow rays and their weights.
 */
#include "recurse/transport/directLight.h"

namespace recurse {

void addSampledLight(const Scene& scene, const ScatteringPoint& scattering, const SurfacePoint& point,
                     const Vec3f& eye, const Rgb& throughput, EyeState eyeState, int samples, LobeSet allowed,
                     Sampler& sampler, PathRadiance& out) {
  const LightTable& lights = scene.lights();
  if (lights.size() == 0) return;
  const PathClasses& classes = out.pathClasses();
  if (classes.join(classes.lightStart(), eyeState) == 0) return;
  for (int i = 0; i < samples; ++i) {
    float pick = sampler.next1D();
    const Vec2f u = sampler.next2D();
    const ChosenLight chosen = lights.choose(pick);
    if (!(chosen.probability > 0)) continue;
    const std::optional<Illumination> light = chosen.light->illuminate(point.position, pick, u);
    if (!light || !(light->pdf > 0)) continue;
    const Rgb f = scattering.evaluate(eye, light->direction);
    if (isBlack(f)) continue;
    const float pdf = chosen.probability * light->pdf;
    const float weight =
        light->delta ? 1 : powerHeuristic(samples, pdf, scattering.pdf(eye, light->direction, allowed));
    if (!visible(scene, point, *light, out.counts)) continue;
    out.add(classes.lightStart(), eyeState,
            throughput * f * light->radiance * (weight / (pdf * static_cast<float>(samples))));
  }
}

Rgb emittedRadiance(const Scene& scene, const Hit& hit, const Vec3f& direction, const BsdfRay& ray,
                    int lightSamples) {
  const Rgb radiance = hit.areaLight->radiance(hit.point, -direction);
  if (!ray.weighted || isBlack(radiance)) return radiance;
  const float lightPdf = scene.lights().probability(hit.lightIndex) *
                         hit.areaLight->pdfIlluminate(ray.from, hit.primitive, hit.point);
  return radiance * (1 - powerHeuristic(lightSamples, lightPdf, ray.pdf));
}

Rgb environmentRadiance(const Scene& scene, const Vec3f& direction, const BsdfRay& ray, int lightSamples) {
  Rgb sum = BLACK;
  const auto& environment = scene.environment();
  for (size_t i = 0; i < environment.size(); ++i) {
    const Rgb radiance = environment[i]->radiance(direction);
    float weight = 1;
    if (ray.weighted) {
      const float lightPdf = scene.lights().probability(scene.environmentIndices()[i]) *
                             environment[i]->pdfIlluminate(direction);
      weight = 1 - powerHeuristic(lightSamples, lightPdf, ray.pdf);
    }
    sum += radiance * weight;
  }
  return sum;
}

} // namespace recurse
