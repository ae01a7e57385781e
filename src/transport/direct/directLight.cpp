/** @file
 * Shadow rays and their MIS weights.
 */
#include "transport/direct/directLight.h"

namespace recurse {

namespace {

/** MIS weight of a light that a ray of density `pdf` hits, and shadow rays find with a density. */
float bsdfRayWeight(float shadowRays, float pdf, const SpectralPath* inMedia) {
  if (!inMedia) return 1 - powerHeuristic(1, shadowRays, pdf);
  return 3 / channelSum(inMedia->pathPdf + inMedia->lightPdf * (shadowRays / pdf));
}

/** Traces a shadow ray from a vertex to the light, through media, thin panes and surfaces that are hidden or
 * do not scatter. Calls passed(const Hit&) for each pane; the transmittance is black if the light is
 * occluded.
 */
template <class Passed>
void transmittanceToLight(const Scene& scene, const Hit& from, const Vec3f& wi, Nesting nesting,
                          const LiSample& light, int hero, int maxPanes, Sampler& sampler,
                          SpectralTransmittance& sum, TransportCounts& counts, Passed& passed) {
  Ray ray = shadowRay(from.point, light);
  if (ray.direction == Vec3f(0)) return;
  // Without panes and hidden surfaces one ray decides, and draws the alpha of all surfaces on its way.
  const bool isDecided = (maxPanes == 0 || !hasPanes(scene)) && scene.nestedIndices().empty();
  if (isDecided) {
    ++counts.rays;
    if (scene.occluded(ray)) {
      sum.value = BLACK;
      return;
    }
  }
  nesting.scatters(from, wi, light.direction);
  BsdfArena arena;
  Hit hit;
  for (int count = 0;;) {
    const bool isHit = intersect(scene, ray, hit, counts);
    if (isHit) nesting.approach(hit, light.direction);
    if (const Medium* medium = scene.medium(nesting.medium(scene))) {
      const float length = glm::length(ray.direction);
      Ray unit = ray;
      unit.direction = light.direction;
      trackTransmittance(*medium, unit, (isHit ? hit.t : ray.tMax) * length, hero, sampler, sum);
    }
    if (isBlack(sum.value) || !isHit) return;
    arena.reset();
    const Bsdf* bsdf = isDecided ? nullptr : bsdfAt(scene, hit, light.direction, Footprint(), nesting, arena);
    if (bsdf) {
      if (count++ < maxPanes)
        sum.value *= paneTransmittance(ScatteringPoint(*bsdf, hit.point), -light.direction);
      else
        sum.value = BLACK;
      if (isBlack(sum.value)) return;
      passed(hit);
    }
    nesting.enterMedium(hit, light.direction);
    if (!passBehind(ray, hit, light)) return;
  }
}

} // namespace

void addSampledLightInMedia(const Scene& scene, const LightSampler& lightSampler,
                            const LightSampleContext& context, const CameraSubpath& path,
                            const CameraVertex& vertex, bool hasRay, int samples, int maxPanes,
                            Sampler& sampler, PathRadiance& out) {
  if (!lightIsSampled(scene, out.pathClasses(), vertex.afterD)) return;
  for (int i = 0; i < samples && !out.abandoned(); ++i) {
    const SampledLight choice(scene.lights(), lightSampler, context, sampler);
    const std::optional<LiSample> light = choice.sampleLi(vertex.point());
    if (!light || !(light->pdf > 0)) continue;
    const float pdf = choice.chosen.probability * light->pdf * static_cast<float>(samples);
    addLightInMedia(scene, path, vertex, hasRay, *light, choice.chosen.index, pdf, maxPanes, sampler, out);
  }
}

void addLightInMedia(const Scene& scene, const CameraSubpath& path, const CameraVertex& vertex, bool hasRay,
                     const LiSample& light, uint32_t index, float pdf, int maxPanes, Sampler& sampler,
                     PathRadiance& out) {
  const Rgb f = vertex.evaluate(light.direction);
  if (isBlack(f)) return;
  SpectralTransmittance through;
  const PathClasses& classes = out.pathClasses();
  PaneSteps steps{classes, vertex.afterD};
  transmittanceToLight(scene, vertex.hit, vertex.wi, path.nesting, light, path.hero, maxPanes, sampler,
                       through, out.counts, steps);
  if (isBlack(through.value)) return;
  Rgb density = through.lightPdf * pdf;
  const auto vertexPdf = [&] { return static_cast<float>(vertex.pdfDirection(light.direction)); };
  const float bsdfPdf = !light.unhittable && hasRay ? vertexPdf() : 0;
  if (bsdfPdf > 0) density += through.pathPdf * bsdfPdf;
  if (PathRecorder* recorder = out.recorder) {
    recordLightSample(*recorder, recorder->source.vertex, light, pdf, bsdfPdf,
                      static_cast<float>(vertex.pdfReverse(light.direction)),
                      recorded::weightOf(through.lightPdf * pdf, density));
    recorder->source.vertexPdf = vertexPdf();
    recorder->source.panes = steps.panes;
  }
  density *= path.pathPdf;
  out.add(classes.lightStart(index), steps.state,
          path.throughput * f * light.radiance * through.value * (3 / channelSum(density)),
          vertex.medium
              ? path.optical.at(distanceToLight(scene, vertex.point().position, light))
              : lengthToLight(scene, path.optical, *vertex.scattering, vertex.wi, vertex.point(), light));
}

void addSampledLight(const Scene& scene, const LightSampler& lightSampler, const LightSampleContext& context,
                     const ScatteringPoint& scattering, const Hit& hit, const Nesting& nesting,
                     const Vec3f& wi, const Rgb& throughput, CameraState cameraState, int samples,
                     LobeSet allowed, int maxPanes, Sampler& sampler, PathRadiance& out,
                     const OpticalPath& optical, const ShadowRayWeight& weight) {
  const PathClasses& classes = out.pathClasses();
  if (!lightIsSampled(scene, classes, cameraState)) return;
  for (int i = 0; i < samples && !out.abandoned(); ++i) {
    const SampledLight choice(scene.lights(), lightSampler, context, sampler);
    const std::optional<LiSample> light = choice.sampleLi(hit.point);
    if (!light) continue;
    Rgb radiance =
        unshadowedRadiance(scattering, wi, throughput, *light, choice.chosen.probability, samples, allowed);
    if (isBlack(radiance)) continue;
    Rgb free;
    PaneSteps steps{classes, cameraState};
    if (scene.hasMedia()) {
      SpectralTransmittance through;
      transmittanceToLight(scene, hit, wi, nesting, *light, NO_HERO, maxPanes, sampler, through, out.counts,
                           steps);
      free = through.value;
    } else {
      free = transmittance(scene, hit, wi, *light, nesting, maxPanes, out.counts, steps);
    }
    if (isBlack(free)) continue;
    if (out.recorder) {
      recordLightSample(*out.recorder, out.recorder->source.vertex, scattering, wi, *light,
                        choice.chosen.probability, samples, allowed);
      out.recorder->source.panes = steps.panes;
    }
    if (weight) {
      const float against = weight(choice.chosen, *light, steps.panes);
      if (out.recorder) out.recorder->source.weight *= against;
      radiance *= against;
    }
    out.add(classes.lightStart(choice.chosen.index), steps.state, radiance * free,
            lengthToLight(scene, optical, scattering, wi, hit.point, *light));
  }
}

LightHit lightHit(const Scene& scene, const LightSampler& lights, const Hit* hit, size_t which,
                  const Ray& ray, const BsdfRay& from, int samples, const SpectralPath* inMedia) {
  LightHit found;
  found.hit = hit;
  const Vec3f& direction = ray.direction;
  const EnvironmentLight* sky = hit ? nullptr : scene.environment()[which];
  if (hit) {
    const SurfacePoint& point = hit->point;
    found.index = hit->lightIndex;
    found.light = hit->areaLight;
    found.emitted = {point.position, -direction, point.geometricNormal, hit->primitive, point.time};
    found.radiance = hit->areaLight->radiance(point, -direction);
  } else {
    found.index = scene.environmentIndices()[which];
    found.light = sky;
    found.emitted = {ray.origin, -direction, Vec3f(0), 0};
    found.radiance = sky->radiance(direction);
    found.beyond = lengthFromInfinity(scene, ray.origin, direction);
  }
  found.weighted = found.radiance;
  if (!from.weighted || isBlack(found.radiance)) return found;
  const Vec3f& start = from.from.position;
  const float pdf =
      hit ? hit->areaLight->pdfLi(start, hit->primitive, hit->point) : lights.pdfLi(*sky, start, direction);
  found.shadowRays =
      static_cast<float>(samples) * lights.probability(scene.lights(), from.from, found.index) * pdf;
  found.weighted *= bsdfRayWeight(found.shadowRays, from.pdf, inMedia);
  return found;
}

} // namespace recurse
