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
  std::vector<EmissionGuide::TrainingSample> useful;
  /** Powers of the photons stored in the visible region if only one photon was emitted [W]. */
  std::vector<float> powers;
  uint64_t stored = 0, inRegion = 0;
  double squares = 0, guided = 0; ///< second moments of contributions: unguided, and with the guide in use
  TransportCounts counts;
  void add(const Trials& o) {
    useful.insert(useful.end(), o.useful.begin(), o.useful.end());
    powers.insert(powers.end(), o.powers.begin(), o.powers.end());
    stored += o.stored;
    inRegion += o.inRegion;
    squares += o.squares;
    guided += o.guided;
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
  const size_t batches = (settings.photons + PHOTON_BATCH - 1) / PHOTON_BATCH;
  std::vector<Trials> parts(batches);
  parallelFor(batches, [&](size_t b) {
    Trials& part = parts[b];
    StoredPhotons stored;
    PhotonWalk walk(scene, classes, settings, part.counts, stored);
    for (uint64_t i = b * PHOTON_BATCH; i < std::min(settings.photons, (b + 1) * PHOTON_BATCH); ++i) {
      stored.clear();
      Sampler sampler(seed, TRIAL_STREAM, static_cast<uint32_t>(i));
      const float time =
          scene.moves() ? scene.camera().timeAt(sampler.next1D()) : 0; // one guide serves all times
      EmissionGuide::TrainingSample start = walk.shoot(sampler, time);
      part.stored += stored.size();
      const double perPhoton = double(settings.photons) / double(start.weight);
      double squares = 0;
      for (const Photon& p : stored.onSurfaces) {
        const auto importance = double(region.importance(p.position));
        if (importance == 0) continue;
        ++part.inRegion;
        part.powers.push_back(maxComponent(p.power) * static_cast<float>(settings.photons));
        squares += importance * square(double(maxComponent(p.power)) * perPhoton);
      }
      // Isotropic media scatter 1/(4π) of the flux per sr, white surfaces 1/π. Second moments have squares.
      constexpr double BY_MEDIUM = 1.0 / 16;
      for (const VolumePhoton& p : stored.inMedia) {
        const auto importance = BY_MEDIUM * double(region.importanceInMedium(p.position));
        if (importance == 0) continue;
        ++part.inRegion;
        squares += importance * square(double(maxComponent(p.power)) * perPhoton);
      }
      part.squares += double(start.weight) * squares;
      part.guided += square(double(start.weight)) * squares;
      start.weight *= static_cast<float>(squares);
      if (start.weight > 0) part.useful.push_back(start);
    }
  });
  Trials all;
  for (const Trials& t : parts) all.add(t);
  return all;
}

/** Number of photons in a round of trials: at most the photons of one pass, so that learning never costs many
 * times as much as its use. */
uint64_t trialPhotons(const ShootSettings& settings) {
  constexpr uint64_t TRIALS = 8 * PHOTON_BATCH;
  return std::min(TRIALS, settings.photons);
}

} // namespace

StartTrial tryStarts(const Scene& scene, const PathClasses& classes, uint64_t seed,
                     const ShootSettings& settings, const VisibleRegion& region, TransportCounts& counts) {
  ShootSettings trial = settings;
  trial.photons = trialPhotons(settings);
  const Trials trials = shootTrials(scene, classes, hashCombine(seed, 0), trial, region);
  counts.add(trials.counts);
  return {trials.inRegion, trials.squares / double(trial.photons)};
}

PhotonGuidance learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                             const ShootSettings& settings, const VisibleRegion& region,
                             const ForwardControl& control, TransportCounts& counts, bool guidesEmission) {
  constexpr int ROUNDS = 5, MAX_ROUNDS = 16;
  constexpr double MIN_RISE = 1.1, MIN_GAIN = 1.5;
  PhotonGuidance guidance;
  if (scene.lights().size() == 0 || region.empty()) return guidance;
  EmissionGuide& guide = guidance.emission;
  ShootSettings trial = settings;
  trial.emission.guide = &guide;
  trial.photons = trialPhotons(settings);
  double squares = 0, guided = 0; // sums over all rounds with a guide, each learned from earlier rounds
  std::vector<EmissionGuide::TrainingSample> useful;
  Trials last;
  // Shoots rounds of trials until the guide stops improving.
  for (int round = 1; round <= MAX_ROUNDS; ++round) {
    last = shootTrials(scene, classes, hashCombine(seed, uint64_t(round - 1)), trial, region);
    counts.add(last.counts);
    if (round > 1) squares += last.squares;
    if (round > 1) guided += last.guided;
    useful.insert(useful.end(), last.useful.begin(), last.useful.end());
    const double before = guide.gain();
    if (guidesEmission) guide = EmissionGuide(useful, double(trial.photons) * round, scene.lights().size());
    // Few hits are unreliable; many hits of an already good density mean that there is no more to gain.
    double weight = 0, squared = 0;
    for (const EmissionGuide::TrainingSample& u : useful) {
      weight += double(u.weight);
      squared += square(double(u.weight));
    }
    const bool wellKnown = square(weight) > squared * double(trial.photons) / 4;
    const bool isSettled = round >= ROUNDS && guide.gain() < MIN_RISE * before;
    if (control.stopped() || (wellKnown && guide.gain() < MIN_GAIN) || isSettled) break;
  }
  // A few photons that scatter hundreds of times in media overestimate the gain of a guide.
  if (guide.gain() < MIN_GAIN || (scene.hasMedia() && squares < guided)) guide = {};
  guidance.splitPower = splitPowerOf(last.powers, trial.photons);
  guidance.storedPhotons = double(last.stored) / double(trial.photons);
  return guidance;
}

EmissionGuide learnEmissionGuide(const Scene& scene, const PathClasses& classes, uint64_t seed, int maxDepth,
                                 const ForwardControl& control, TransportCounts& counts, uint64_t trials) {
  ShootSettings trial;
  trial.photons = trials;
  trial.maxDepth = maxDepth;
  const VisibleRegion region = probeRegion(scene, {}, counts);
  return learnGuidance(scene, classes, seed, trial, region, control, counts).emission;
}

} // namespace recurse
