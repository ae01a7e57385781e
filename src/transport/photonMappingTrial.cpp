/** @file
 * Whether the picture is left to path tracing, by a trial on a few blocks of it.
 */
#include "transport/photonMappingIntegrator.h"

#include "recurse/core/text.h"
#include "recurse/model/plugIns.h"
#include "recurse/transport/estimatorTrial.h"

namespace recurse {

bool PhotonMapping::mayLeaveItToPaths(const Scene& scene) const {
  constexpr int MAX_LIGHT_SAMPLES = 64; // with more, a trial may take longer than the picture
  if (settings.lightSamples > MAX_LIGHT_SAMPLES) return false;
  if (!settings.trial || !mayGoOn() || settings.nearest > 0 || settings.radius > 0 || settings.directLight)
    return false;
  bool met = true; // by rays, as lamps far away hardly are
  for (uint32_t i = 0; i < scene.lights().size(); ++i)
    met = met && scene.lights()[i].isMet() && !photons.isAimed(i);
  return scene.lights().size() > 0 && (met || photons.caustics().map.empty()) &&
         scene.film().whole().area() >= EstimatorTrial::PIXELS;
}

void PhotonMapping::tryPaths(const Scene& scene, const PathClasses& classes, const Pass& pass,
                             const ForwardControl& control, ForwardStatistics& statistics) {
  constexpr uint64_t STREAM = 0x747269616cull;
  constexpr double PASS_RAY = 2; // to shoot, store and sort, over a ray of a camera path
  const Pass other{hashCombine(pass.seed, STREAM), 1, false, pass.time};
  const EstimatorTrial trial(scene, classes, other.seed, pass.time);
  Diagnostics diagnostics;
  std::unique_ptr<Integrator> tracer = plugIns().integrators.make(
      parseParameterText("path", formatted("\"integer maxdepth\" %d \"integer lightsamples\" %d",
                                           settings.maxDepth, settings.lightSamples)),
      {}, diagnostics);
  tracer->prepare(scene, classes);
  statistics.counts.add(tracer->forward(scene, classes, pass, control).counts);
  EstimatorTrial::Rounds traced{trial.take(*tracer, 0), trial.take(*tracer, 1)}, mapped;
  mapped[0] = trial.take(*this, 0);
  const ForwardStatistics shot =
      photons.with(other, scene, classes, control, lights, [&] { mapped[1] = trial.take(*this, 1); });
  for (const EstimatorTrial::Rounds* rounds : {&traced, &mapped})
    for (const TrialSamples& samples : *rounds) statistics.counts.add(samples.counts);
  statistics.counts.add(shot.counts);
  if (control.stopped()) return;
  EstimatorTrial::Figures byMap = EstimatorTrial::figures(mapped, traced),
                          byPaths = EstimatorTrial::figures(traced, mapped);
  byMap.work += PASS_RAY * double(shot.counts.rays) / double(scene.film().whole().area());
  byPaths.add(photons.causticVarianceByRays() + EstimatorTrial::missedVariance(traced, mapped));
  const double ratio = byMap.errorOver(byPaths);
  constexpr double CLEARLY = 2; // a trial misses rare bright samples, of which paths have more
  if (!(ratio > CLEARLY)) return;
  statistics.notes.push_back(formatted("photons: the picture is left to path tracing, which by a trial has "
                                       "1/%.2g of the squared error for the "
                                       "same work (\"bool trial\" false: photons anyway)",
                                       ratio));
  pathTracer = std::move(tracer);
}

} // namespace recurse
