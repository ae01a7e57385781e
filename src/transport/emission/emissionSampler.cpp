/** @file
 * Emission of light paths by lights, chosen by power, and by media.
 */
#include "transport/emission/emissionSampler.h"

#include <algorithm>

#include "recurse/core/sampling/sampling.h"
#include "transport/paths/walk.h"

namespace recurse {

LePdf EmissionSettings::pdfLe(uint32_t index, const Light& light, const LeRay& ray) const {
  LePdf pdf = light.pdfLe(ray);
  if (isAimed(index)) pdf.direction = aim->pdfDirection(light, ray, pdf.direction);
  if (entersByPortals(light)) pdf.position = portals->pdf(ray.origin, ray.direction);
  return pdf;
}

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

EmissionGuide::TrainingSample EmissionSampler::draw(Sampler& sampler) const {
  const float light = sampler.next1D(), part = sampler.next1D();
  const Vec2f position = sampler.next2D(), direction = sampler.next2D();
  EmissionGuide::TrainingSample sample{{light, part, position.x, position.y, direction.x, direction.y}, 1};
  if (settings.guide && settings.guide->active())
    sample.weight = 1 / settings.guide->warp(sample.numbers, sampler.next1D());
  return sample;
}

bool EmissionSampler::start(const EmissionGuide::TrainingSample& sample, float time, Sampler& sampler,
                            LightStart& start) const {
  start = {};
  const bool byMedium = mediaPart > 0 && (mediaPart >= 1 || sampler.next1D() < mediaPart);
  if (byMedium)
    fromMedium(sample.numbers, time, start);
  else if (!fromLight(sample.numbers, time, sampler, start))
    return false;
  LightSubpath& path = start.path;
  path.throughput *= sample.weight / (byMedium ? mediaPart : 1 - mediaPart);
  if (!isFinite(path.throughput)) {
    ++counts.nonFinite;
    return false;
  }
  if (isBlack(path.throughput) || classes.dead(path.state)) return false;
  path.from = path.ray.origin;
  const bool isInfinite = start.end.light && start.end.isInfinite();
  if (!byMedium) path.nesting = nestingAt(scene, path.ray, counts);
  path.optical = opticalStart(scene, classes, path.ray, path.nesting, isInfinite, counts);
  if (!scene.hasMedia()) return true;
  if (!byMedium) {
    const uint16_t declared = isInfinite ? settings.outside : scene.lightMedium(start.end.index);
    path.nesting.startIn(declared ? declared : mediumAround(scene, path.ray, 0, counts));
  }
  path.hero = std::min(2, static_cast<int>(3 * sampler.next1D()));
  return true;
}

void EmissionSampler::fromMedium(const EmissionGuide::Numbers& n, float time, LightStart& start) const {
  auto [position, nesting, power, medium] =
      settings.media->sample(scene, time, n[0], {n[1], n[2], n[3]}, counts);
  start.path.ray = {position, uniformSphere({n[4], n[5]}), INFINITE, time};
  start.path.throughput = power;
  start.path.state = startInMedium(scene, classes, medium);
  start.path.nesting = nesting;
}

bool EmissionSampler::fromLight(const EmissionGuide::Numbers& n, float time, Sampler& sampler,
                                LightStart& start) const {
  const LightTable& lights = settings.table(scene);
  float pick = n[0];
  const size_t chosen = lights.chooseIndex(pick);
  const auto index = static_cast<uint32_t>(chosen);
  const float probability = lights.probability(chosen);
  if (!(probability > 0)) return false;
  const Light& light = lights[chosen];
  const bool aimed = settings.isAimed(index);
  const Vec2f towards{n[4], n[5]};
  std::optional<LeSample> emission =
      light.sampleLe({n[1], {n[2], n[3]}, aimed ? sampler.next2D() : towards, time});
  if (!emission) return false;
  if (aimed) settings.aim->redirect(light, *emission, pick, towards);
  if (isBlack(emission->flux)) return false;
  if (settings.entersByPortals(light)) settings.portals->redirect(*emission, pick, {n[2], n[3]});
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

std::optional<LightStart> startLightSubpath(const Scene& scene, const PathClasses& classes, float time,
                                            Sampler& sampler, TransportCounts& counts,
                                            const EmissionGuide* guide) {
  EmissionSettings settings;
  settings.guide = guide;
  const EmissionSampler starts(scene, classes, settings, counts);
  LightStart start;
  if (!starts.start(starts.draw(sampler), time, sampler, start)) return {};
  return start;
}

} // namespace recurse
