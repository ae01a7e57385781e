/** @file
 * Light of lamps that a medium scatters into a ray.
 */
#include "transport/direct/lightAlongRay.h"

namespace recurse {

namespace {

/** Of the distances one is chosen from by what light there is, shadows aside. Most of a ray may lie outside
 * of the cone of a spot, or behind an area; of light from far away only shadows are not the same all along.
 */
int candidatePairs(const Light& light) {
  if (light.isInfinite()) return 1;
  return light.kind() == LightKind::POINT ? 8 : 2;
}

} // namespace

std::optional<LightAlongRay> sampleLightAlong(const Scene& scene, const LightSampler& lightSampler,
                                              const Medium& medium, const Ray& ray, float end,
                                              const RaysToLights& rays, int which, Sampler& sampler) {
  const MediumPoint point = medium.at(ray.origin);
  const Rgb extinction = point.extinction();
  const TransmittanceDistance open(extinction, end);
  // The lamp is chosen from a place that does not depend on the distances.
  const SurfacePoint from = pointInMedium(ray, open.sample(sampler.next1D(), sampler.next1D()));
  const SampledLight choice(scene.lights(), lightSampler, {from.position}, sampler);
  const ChosenLight& chosen = choice.chosen;
  if (!(chosen.probability > 0)) return {};
  const int count = rays.to(*chosen.light);
  if (which >= count) return {};
  /** About the lamp's point by `u`. Where light is sampled by area, that is the shadow ray's, and the density
   * of distances has the 1/r² of the light. */
  const auto nearnessTo = [&](const Vec2f& u) {
    std::optional<EquiangularDistance> near;
    if (const std::optional<LeSample> start = chosen.light->sampleLe({choice.pick, u, choice.u, ray.time}))
      near.emplace(ray, end, start->origin);
    if (near && !near->usable()) near.reset();
    return near;
  };
  const bool area = chosen.light->kind() == LightKind::AREA;
  std::optional<EquiangularDistance> near;
  if (!area && !chosen.light->isInfinite()) near = nearnessTo(sampler.next2D());

  std::optional<LightAlongRay> kept;
  float keptWorth = 0;
  float sum = 0;
  float pick = sampler.next1D();
  const auto consider = [&](float t, const Vec2f& u) {
    const SurfacePoint place = pointInMedium(ray, t);
    const std::optional<LiSample> light =
        lightSampler.sampleLi(*chosen.light, place.time, place.position, choice.pick, u);
    if (!light || !(light->pdf > 0)) return;
    // Of colours that a medium scatters unequally, each is brought by its own distances.
    const float worth = luminance(light->radiance * point.scattering * flight::transmittance(extinction, t)) *
                        medium.phase->value(glm::dot(light->direction, ray.direction));
    const float pdf = near ? (open.pdf(t) + near->pdf(t)) / 2 : open.pdf(t);
    const float density = pdf * chosen.probability * light->pdf;
    if (!(worth > 0) || !(density > 0 && density < INFINITE)) return;
    const float weight = worth / density;
    sum += weight;
    const float chance = weight / sum;
    if (pick < chance) {
      kept = {t, *light, 0};
      keptWorth = worth;
      pick /= chance;
    } else {
      pick = (pick - chance) / (1 - chance);
    }
  };
  const int pairs = candidatePairs(*chosen.light);
  const float u = sampler.next1D();
  for (int i = 0; i < pairs; ++i) {
    const float part = (static_cast<float>(i) + u) / static_cast<float>(pairs);
    const float place = area ? part : (static_cast<float>(which) + part) / static_cast<float>(count);
    const Vec2f onLamp = sampler.next2D();
    if (area) near = nearnessTo(onLamp);
    consider(open.sample(sampler.next1D(), place), onLamp);
    consider(near ? std::min(near->sample(place), end) : open.sample(sampler.next1D(), place), onLamp);
  }
  if (kept) kept->reciprocalPdf = sum / (static_cast<float>(2 * pairs * count) * keptWorth);
  return kept;
}

} // namespace recurse
