/** @file
 * Light of lamps that a medium scatters into a ray.
 */
#include "transport/direct/lightAlongRay.h"

namespace recurse {

namespace {

/** Number of pairs of candidate distances, resampled by unoccluded light. Most of a ray may be outside of the
 * cone of a spot light, or behind an area light; for infinite lights only visibility varies along it.
 */
int candidatePairs(const Light& light) {
  if (light.isInfinite()) return 1;
  return light.kind() == LightKind::POINT ? 8 : 2;
}

/** Equiangular distances about the lamp's point for `u`. Where light is sampled by area, the shadow ray ends
 * at this point too, so that the density of distances contains the 1/r² of the light. */
std::optional<EquiangularDistance> distanceToLamp(const SampledLight& choice, const Ray& ray, float end,
                                                  const Vec2f& u) {
  const std::optional<LeSample> start = choice.chosen.light->sampleLe({choice.pick, u, choice.u, ray.time});
  if (!start) return {};
  const EquiangularDistance near(ray, end, start->origin);
  return near.usable() ? std::optional(near) : std::nullopt;
}

} // namespace

std::optional<LightAlongRay> sampleLightAlong(const Scene& scene, const LightSampler& lightSampler,
                                              const Medium& medium, const Ray& ray, float end,
                                              const RaysToLights& rays, int which, Sampler& sampler) {
  const MediumPoint point = medium.at(ray.origin);
  const Rgb extinction = point.extinction();
  const TransmittanceDistance open(extinction, end);
  // The choice of the lamp uses a point that is independent of the candidate distances.
  const SurfacePoint from = pointInMedium(ray, open.sample(sampler.next1D(), sampler.next1D()));
  const SampledLight choice(scene.lights(), lightSampler, {from.position}, sampler);
  const ChosenLight& chosen = choice.chosen;
  if (!(chosen.probability > 0)) return {};
  const int count = rays.to(*chosen.light);
  if (which >= count) return {};
  const bool area = chosen.light->kind() == LightKind::AREA;
  std::optional<EquiangularDistance> near;
  if (!area && !chosen.light->isInfinite()) near = distanceToLamp(choice, ray, end, sampler.next2D());

  std::optional<LightAlongRay> selected;
  float selectedTarget = 0, sum = 0;
  float pick = sampler.next1D();
  const auto consider = [&](float t, const Vec2f& u) {
    const SurfacePoint scatterer = pointInMedium(ray, t);
    const std::optional<LiSample> light =
        lightSampler.sampleLi(*chosen.light, scatterer.time, scatterer.position, choice.pick, u);
    if (!light || !(light->pdf > 0)) return;
    // With the scattering coefficient, channels that scatter more decide the distances.
    const float target =
        luminance(light->radiance * point.scattering * flight::transmittance(extinction, t)) *
        medium.phase->value(glm::dot(light->direction, ray.direction));
    const float pdf = near ? (open.pdf(t) + near->pdf(t)) / 2 : open.pdf(t);
    const float density = pdf * chosen.probability * light->pdf;
    if (!(target > 0) || !(density > 0 && density < INFINITE)) return;
    const float weight = target / density;
    sum += weight;
    const float chance = weight / sum;
    if (pick < chance) {
      selected = {t, *light, chosen.index, 0};
      selectedTarget = target;
      pick /= chance;
    } else {
      pick = (pick - chance) / (1 - chance);
    }
  };
  const int pairs = candidatePairs(*chosen.light);
  const float u = sampler.next1D();
  for (int i = 0; i < pairs; ++i) {
    const float u1 = (static_cast<float>(i) + u) / static_cast<float>(pairs);
    const float stratum = area ? u1 : (static_cast<float>(which) + u1) / static_cast<float>(count);
    const Vec2f onLamp = sampler.next2D();
    if (area) near = distanceToLamp(choice, ray, end, onLamp);
    consider(open.sample(sampler.next1D(), stratum), onLamp);
    consider(near ? std::min(near->sample(stratum), end) : open.sample(sampler.next1D(), stratum), onLamp);
  }
  if (selected) selected->reciprocalPdf = sum / (static_cast<float>(2 * pairs * count) * selectedTarget);
  return selected;
}

} // namespace recurse
