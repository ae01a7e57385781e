/** @file
 * Whether the picture is left to path tracing, by a trial on a few blocks of it.
 */
#include "transport/photonMappingIntegrator.h"

#include "recurse/core/text.h"
#include "recurse/transport/estimatorTrial.h"
#include "recurse/transport/pathTracing.h"

namespace recurse {

std::unique_ptr<Integrator> PhotonMapping::pathTracerBeside(const CausticPhotons* caustic, const Scene& scene,
                                                            const PathClasses& classes) {
  auto made = makePathTracing({settings.maxDepth, settings.lightSamples}, caustic);
  made->prepare(scene, classes);
  const Pass any;
  learned.add(made->forward(scene, classes, any, {}).counts);
  return made;
}

bool PhotonMapping::mayLeaveItToPaths(const Scene& scene) const {
  constexpr int MAX_LIGHT_SAMPLES = 64; // with more, a trial may take longer than the picture
  if (settings.lightSamples > MAX_LIGHT_SAMPLES) return false;
  if (!settings.trial || !mayGoOn() || settings.nearest > 0 || settings.radius > 0 || settings.directLight)
    return false;
  // Beside paths photons are kept on surfaces only.
  if (scene.hasMedia() && !raysFindAll(scene)) return false;
  return scene.lights().size() > 0 && scene.film().whole().area() >= EstimatorTrial::PIXELS;
}

bool PhotonMapping::raysFindAll(const Scene& scene) const {
  const bool causticsInMedia = scene.hasMedia() && (scene.contents().lobes & DELTA_LOBES);
  if (photons.caustics().map.empty() && !causticsInMedia) return true;
  bool met = true; // by rays, as lamps far away hardly are
  for (uint32_t i = 0; i < scene.lights().size(); ++i)
    met = met && scene.lights()[i].isIntersectable() && !photons.isAimed(i);
  return met;
}

void PhotonMapping::tryPaths(const Scene& scene, const PathClasses& classes, const Pass& pass,
                             const ForwardControl& control, ForwardStatistics& statistics) {
  constexpr uint64_t STREAM = 0x747269616cull;
  constexpr double PASS_RAY = 1.6; // to shoot, store and sort, over a ray of a camera path
  constexpr double CLEARLY = 2;    // a trial misses rare bright samples, of which paths have more
  const Pass other{hashCombine(pass.seed, STREAM), 1, false, pass.time};
  const EstimatorTrial trial(scene, classes, other.seed, pass.time);
  const double pixels = double(scene.film().whole().area());
  using Rounds = EstimatorTrial::Rounds;
  // A round by this pass's photons, and one by another's.
  const auto takeBoth = [&](Integrator& integrator, auto& ofPasses, double& shotRays) {
    Rounds rounds{trial.take(integrator, 0), {}};
    const ForwardStatistics shot =
        ofPasses.with(other, scene, classes, control, lights, [&] { rounds[1] = trial.take(integrator, 1); });
    statistics.counts.add(shot.counts);
    shotRays = double(shot.counts.rays);
    return rounds;
  };
  std::unique_ptr<Integrator> plain = pathTracerBeside(nullptr, scene, classes), withCaustics;
  const Rounds traced{trial.take(*plain, 0), trial.take(*plain, 1)};
  double shot = 0;
  const Rounds mapped = takeBoth(*this, photons, shot);
  EstimatorTrial::Figures byMap = EstimatorTrial::figures(mapped, traced);
  byMap.work += PASS_RAY * shot / pixels;
  EstimatorTrial::Figures byPaths = EstimatorTrial::figures(traced, mapped);
  byPaths.add(photons.causticVarianceByRays() + EstimatorTrial::missedVariance(traced, mapped));
  for (const Rounds* rounds : {&traced, &mapped})
    for (const TrialSamples& samples : *rounds) statistics.counts.add(samples.counts);
  std::unique_ptr<CausticPhotons> causticPhotons;
  if (!photons.caustics().map.empty()) {
    causticPhotons = std::make_unique<CausticPhotons>(settings);
    statistics.counts.add(causticPhotons->run(scene, classes, pass, control, lights).counts);
    withCaustics = pathTracerBeside(causticPhotons.get(), scene, classes);
    const Rounds both = takeBoth(*withCaustics, *causticPhotons, shot);
    for (const TrialSamples& samples : both) statistics.counts.add(samples.counts);
    EstimatorTrial::Figures byBoth = EstimatorTrial::figures(both, mapped);
    byBoth.work += PASS_RAY * shot / pixels;
    byBoth.add(EstimatorTrial::missedVariance(both, mapped));
    if (!raysFindAll(scene) || byBoth.errorOver(byPaths) < CLEARLY) {
      byPaths = byBoth;
      plain = std::move(withCaustics);
    } else {
      causticPhotons.reset();
    }
  }
  statistics.counts.add(std::exchange(learned, {}));
  if (control.stopped()) return;
  // Behind a door ajar neither finds enough light to be judged; photons find their way sooner.
  constexpr double FEW = 64; // the scenes that are better left to paths have hundreds and more
  const double ratio = byMap.errorOver(byPaths);
  if (!(ratio > CLEARLY) || EstimatorTrial::effectiveCount(traced) < FEW) return;
  statistics.notes.push_back(
      formatted("photons: the picture is left to path tracing%s, which by a trial has 1/%.2g of the squared "
                "error for the same work (\"bool trial\" false: photons anyway)",
                causticPhotons ? " with photons of caustics only" : "", ratio));
  pathTracer = std::move(plain);
  caustics = std::move(causticPhotons);
}

} // namespace recurse
