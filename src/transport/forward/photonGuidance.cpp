/** @file
 * Learning of the emission guide and the splitting power from trial photons.
 */
#include "transport/forward/photonGuidance.h"

#include <algorithm>
#include <numeric>

#include "recurse/core/threads/parallel.h"
#include "transport/emission/cameraProbe.h"
#include "transport/forward/photonWalk.h"

namespace recurse {

namespace {

/** Sampler stream of trial photons, distinct from the streams of photons and pixels. */
constexpr uint64_t TRIAL_STREAM = 0x545249414c53ull;

/** Sums over trial photons. */
struct Trials {
  explicit Trials(const EmissionMixture& mixture) : moments(mixture) {}
  EmissionMixture::Moments moments;
  /** Powers of the photons stored in the visible region if only one photon was emitted [W]. */
  std::vector<float> powers;
  uint64_t stored = 0;
  TransportCounts counts;
  void add(const Trials& o) {
    moments.add(o.moments);
    powers.insert(powers.end(), o.powers.begin(), o.powers.end());
    stored += o.stored;
    counts.add(o.counts);
  }
};

/** Power above which photons are split, such that it adds no more photons than are emitted. */
float splitPowerOf(std::vector<float> powers, uint64_t emitted) {
  constexpr float OVER_TYPICAL = 2;
  if (powers.empty()) return INFINITE;
  const auto middle = powers.begin() + static_cast<std::ptrdiff_t>(powers.size() / 2);
  std::nth_element(powers.begin(), middle, powers.end());
  const double sum = std::accumulate(powers.begin(), powers.end(), 0.0);
  return std::max(OVER_TYPICAL * *middle, static_cast<float>(sum / double(emitted)));
}

Trials shootTrials(const Scene& scene, const PathClasses& classes, uint64_t seed,
                   const ShootSettings& settings, const VisibleRegion& region) {
  const EmissionMixture& mixture = *settings.emission.mixture;
  const size_t batches = (settings.photons + PHOTON_BATCH - 1) / PHOTON_BATCH;
  std::vector<Trials> parts(batches, Trials(mixture));
  parallelFor(batches, [&](size_t b) {
    Trials& trials = parts[b];
    StoredPhotons stored;
    PhotonWalk walk(scene, classes, settings, trials.counts, stored);
    for (uint64_t i = b * PHOTON_BATCH; i < std::min(settings.photons, (b + 1) * PHOTON_BATCH); ++i) {
      stored.clear();
      Sampler sampler(seed, TRIAL_STREAM, static_cast<uint32_t>(i));
      const float time =
          scene.moves() ? scene.camera().timeAt(sampler.next1D()) : 0; // one guide serves all times
      const LightStart* start = walk.shoot(sampler, time);
      trials.stored += stored.size();
      const auto emitted = static_cast<float>(settings.photons);
      double squares = 0;
      for (const Photon& p : stored.onSurfaces) {
        const auto importance = double(region.importance(p.position));
        if (importance == 0) continue;
        trials.powers.push_back(maxComponent(p.power) * emitted);
        squares += importance * square(double(trials.powers.back()));
      }
      // Isotropic media scatter 1/(4π) of the flux per sr, white surfaces 1/π. Second moments have squares.
      constexpr double BY_MEDIUM = 1.0 / 16;
      for (const VolumePhoton& p : stored.inMedia)
        squares += BY_MEDIUM * double(region.importanceInMedium(p.position)) *
                   square(double(maxComponent(p.power) * emitted));
      if (squares > 0 && start->end.light && mixture.active())
        trials.moments.add(start->end.index, start->end.ray, squares);
    }
  });
  Trials all(mixture);
  for (const Trials& t : parts) all.add(t);
  return all;
}

} // namespace

PhotonGuidance learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                             const ShootSettings& settings, const VisibleRegion& region,
                             const ForwardControl& control, TransportCounts& counts, bool mixes) {
  constexpr int ROUNDS = 3;
  PhotonGuidance guidance;
  if (scene.lights().size() == 0 || region.empty()) return guidance;
  if (mixes) guidance.emission = EmissionMixture(scene, seed, counts);
  ShootSettings trial = settings;
  trial.emission.mixture = &guidance.emission;
  // At most the photons of one pass, so that learning never costs many times as much as its use.
  trial.photons = std::min(8 * PHOTON_BATCH, settings.photons);
  for (int round = guidance.emission.active() ? 1 : ROUNDS; round <= ROUNDS && !control.stopped(); ++round) {
    const Trials trials = shootTrials(scene, classes, hashCombine(seed, uint64_t(round)), trial, region);
    counts.add(trials.counts);
    guidance.emission.adapt(trials.moments);
    if (round < ROUNDS) continue;
    guidance.splitPower = splitPowerOf(trials.powers, trial.photons);
    guidance.storedPhotons = double(trials.stored) / double(trial.photons);
  }
  return guidance;
}

EmissionMixture learnEmission(const Scene& scene, const PathClasses& classes, uint64_t seed, int maxDepth,
                              const ForwardControl& control, TransportCounts& counts, uint64_t trials) {
  ShootSettings trial;
  trial.photons = trials;
  trial.maxDepth = maxDepth;
  const VisibleRegion region = probeRegion(scene, {}, counts);
  return learnGuidance(scene, classes, seed, trial, region, control, counts, true).emission;
}

} // namespace recurse
