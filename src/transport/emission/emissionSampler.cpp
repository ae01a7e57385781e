/** @file
 * Emission of light paths by lights and media.
 */
#include "transport/emission/emissionSampler.h"

#include <algorithm>

#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/surroundingMedium.h"
#include "transport/paths/walk.h"

namespace recurse {

/** Fraction of the paths that emissive media start: proportional to power, but between a tenth and nine
 * tenths if the scene has lights, too. */
float EmissionSampler::partOfMedia() const {
  constexpr double MAX_PART = 0.9;
  if (!settings.media || settings.media->empty()) return 0;
  const LightTable& lights = settings.table(scene);
  double byLights = 0;
  for (size_t i = 0; i < lights.size(); ++i) byLights += double(maxComponent(lights[i].power()));
  if (!(byLights > 0)) return 1;
  const double byMedia = settings.media->power();
  return static_cast<float>(std::clamp(byMedia / (byMedia + byLights), 1 - MAX_PART, MAX_PART));
}

std::optional<LightStart> EmissionSampler::start(float time, Sampler& sampler) const {
  LightStart start;
  const bool byMedium = mediaPart > 0 && (mediaPart >= 1 || sampler.next1D() < mediaPart);
  if (byMedium)
    fromMedium(time, sampler, start);
  else if (!fromLight(time, sampler, start))
    return {};
  LightSubpath& path = start.path;
  path.throughput /= byMedium ? mediaPart : 1 - mediaPart;
  if (!isFinite(path.throughput)) {
    ++counts.nonFinite;
    return {};
  }
  if (isBlack(path.throughput) || classes.dead(path.state)) return {};
  path.from = path.ray.origin;
  const bool isInfinite = start.end.light && start.end.isInfinite();
  if (!byMedium) path.nesting = nestingAt(scene, path.ray, counts);
  path.optical = opticalStart(scene, classes, path.ray, path.nesting, isInfinite, counts);
  if (!scene.hasMedia()) return start;
  if (!byMedium && isInfinite)
    path.nesting.startIn(settings.outside);
  else if (!byMedium) {
    const auto [medium, varies] = scene.lightMedium(start.end.index);
    path.nesting.startIn(
        varies || scene.moves() ? mediumAround(scene, {&path.ray, 1}, medium, counts.rays).index : medium);
  }
  path.hero = drawHero(sampler.next1D());
  return start;
}

void EmissionSampler::fromMedium(float time, Sampler& sampler, LightStart& start) const {
  const float pick = sampler.next1D();
  const Vec2f u = sampler.next2D();
  auto [position, nesting, power, medium] =
      settings.media->sample(scene, time, pick, {u.x, u.y, sampler.next1D()}, counts);
  start.path.ray = {position, uniformSphere(sampler.next2D()), INFINITE, time};
  start.path.throughput = power;
  start.path.state = startInMedium(scene, classes, medium);
  start.path.nesting = nesting;
}

bool EmissionSampler::fromLight(float time, Sampler& sampler, LightStart& start) const {
  const LightTable& lights = settings.table(scene);
  float pick = sampler.next1D();
  const size_t chosen = lights.chooseIndex(pick);
  const auto index = static_cast<uint32_t>(chosen);
  const float probability = lights.probability(chosen);
  if (!(probability > 0)) return false;
  const Light& light = lights[chosen];
  LeRandom random;
  random.pick = sampler.next1D();
  random.position = sampler.next2D();
  random.direction = sampler.next2D();
  random.time = time;
  std::optional<LeSample> emission = light.sampleLe(random);
  if (!emission) return false;
  if (settings.isMixed()) settings.mixture->redirect(index, *emission, pick, sampler.next2D());
  if (isBlack(emission->flux)) return false;
  start.probability = probability;
  start.pdf = {emission->pdfPosition, emission->pdfDirection};
  LightEnd& end = start.end;
  end.light = &light;
  end.index = index;
  end.ray = *emission;
  LightSubpath& path = start.path;
  path.ray = {emission->origin, emission->direction, INFINITE, time};
  path.throughput = emission->flux / probability;
  path.state = classes.lightStart(chosen);
  path.parallel = end.isInfinite();
  const double byPosition = double(emission->pdfPosition), byDirection = double(emission->pdfDirection);
  path.pdf = path.parallel ? byPosition : byDirection;
  end.pdf = (path.parallel ? byDirection : byPosition) * double(probability);
  if (path.parallel) path.throughput *= settings.outsideTransmittance;
  if (light.kind() == LightKind::AREA) path.cosine = absDot(emission->direction, emission->normal);
  return true;
}

} // namespace recurse
