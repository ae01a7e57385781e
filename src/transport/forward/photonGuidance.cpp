/** @file
 * What trial photons teach.
 */
#include "transport/forward/photonGuidance.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "recurse/core/threads/parallel.h"
#include "transport/emission/cameraProbe.h"
#include "transport/forward/photonWalk.h"

namespace recurse {

namespace {

/** Tells trial samples from those of photons and pixels. */
constexpr uint64_t TRIAL_STREAM = 0x545249414c53ull;

/** Trial photons, added up. */
struct Trials {
  std::vector<EmissionGuide::TrainingSample> useful;
  /** Of those in the region. */
  struct Arrived {
    float power;                   ///< in all that one photon emitted carries
    float startDensity, fullPower; ///< see PhotonWalk
  };
  std::vector<Arrived> powers;
  uint64_t inRegion = 0;
  double squares = 0, guided = 0; ///< of what photons bring: without a guide, and with the one they had
  TransportCounts counts;
  void add(const Trials& o) {
    useful.insert(useful.end(), o.useful.begin(), o.useful.end());
    powers.insert(powers.end(), o.powers.begin(), o.powers.end());
    inRegion += o.inRegion;
    squares += o.squares;
    guided += o.guided;
    counts.add(o.counts);
  }
};

/** What no photon should carry more than; not so little that splitting makes more photons than are emitted.
 */
float splitPowerOf(std::vector<float> powers, uint64_t emitted) {
  constexpr float OVER_TYPICAL = 2;
  if (powers.empty()) return INFINITE;
  const auto middle = powers.begin() + static_cast<std::ptrdiff_t>(powers.size() / 2);
  std::nth_element(powers.begin(), middle, powers.end());
  const double sum = std::accumulate(powers.begin(), powers.end(), 0.0);
  return std::max(OVER_TYPICAL * *middle, static_cast<float>(sum / double(emitted)));
}

/** Finds out which light starts too sparsely for photons. */
void leaveToRays(const Trials& trials, PhotonGuidance& guidance) {
  constexpr float MAX_POWER = 32; // over that of most: each is a stain on its own
  constexpr double WORTH_IT = 4;  // times less variance of what photons bring, for grain of rays
  double starts = 0, far = 0;
  for (const Trials::Arrived& a : trials.powers) {
    if (!(a.startDensity < INFINITE)) continue;
    starts += double(a.startDensity) * double(a.fullPower);
    ++far;
  }
  if (!(starts > 0)) return;
  // Light infinitely far is chosen by power, so that the product is nearly the same for all.
  const auto least = static_cast<float>(starts / far / double(MAX_POWER * guidance.splitPower));
  double all = 0, sparse = 0, squares = 0, sparseSquares = 0;
  for (const Trials::Arrived& a : trials.powers) {
    const double power = double(a.power);
    all += power;
    squares += square(power);
    if (!(a.startDensity < least)) continue;
    sparse += power;
    sparseSquares += square(power);
  }
  if (!(squares > WORTH_IT * (squares - sparseSquares))) return;
  guidance.minStartDensity = least;
  guidance.sparsePart = static_cast<float>(sparse / all);
}

/** Number of samples of equal weight with the same relative variance of their sum. */
double effectiveCount(const std::vector<EmissionGuide::TrainingSample>& samples) {
  double sum = 0, squared = 0;
  for (const EmissionGuide::TrainingSample& s : samples) {
    sum += double(s.weight);
    squared += square(double(s.weight));
  }
  return squared > 0 ? square(sum) / squared : 0;
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
          scene.moves() ? scene.camera().timeAt(sampler.next1D()) : 0; // the guide is for all times
      EmissionGuide::TrainingSample start = walk.shoot(sampler, time);
      const double perPhoton = double(settings.photons) / double(start.weight);
      double squares = 0;
      for (const Photon& p : stored.onSurfaces) {
        const auto importance = double(region.importance(p.position));
        if (importance == 0) continue;
        ++part.inRegion;
        part.powers.push_back({maxComponent(p.power) * static_cast<float>(settings.photons),
                               walk.startDensity(), walk.fullPower() * static_cast<float>(settings.photons)});
        squares += importance * square(double(maxComponent(p.power)) * perPhoton);
      }
      // What is scattered evenly is seen by 1/4π of it, on a white surface by 1/π; errors go by the square.
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

} // namespace

PhotonGuidance learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                             const ShootSettings& settings, const VisibleRegion& region,
                             const ForwardControl& control, TransportCounts& counts, bool usesEmission) {
  constexpr uint64_t TRIALS = 8 * PHOTON_BATCH;
  constexpr int ROUNDS = 5, MAX_ROUNDS = 16;
  constexpr double MIN_RISE = 1.1, MIN_GAIN = 1.5;
  PhotonGuidance guidance;
  if (scene.lights().size() == 0 || region.empty()) return guidance;
  EmissionGuide& guide = guidance.emission;
  ShootSettings trial = settings;
  trial.guide = &guide;
  // No more than a pass has: learning must not cost many times what it serves.
  trial.photons = std::min(TRIALS, settings.photons);
  std::vector<EmissionGuide::TrainingSample> useful;
  Trials last;
  double squares = 0, guided = 0; // of all rounds with a guide, each learned from those before
  for (int round = 1;; ++round) {
    last = shootTrials(scene, classes, hashCombine(seed, static_cast<uint64_t>(round - 1)), trial, region);
    counts.add(last.counts);
    if (round == 1) {
      guidance.useful = last.inRegion;
    } else {
      squares += last.squares;
      guided += last.guided;
    }
    useful.insert(useful.end(), last.useful.begin(), last.useful.end());
    const double before = guide.gain();
    if (usesEmission) guide = EmissionGuide(useful, double(trial.photons) * round, scene.lights().size());
    // Few hits say little yet; many of a density that is good already, that there is no more to gain.
    const bool isKnown = effectiveCount(useful) * 4 > double(trial.photons);
    if (control.stopped() || (isKnown && guide.gain() < MIN_GAIN) || round == MAX_ROUNDS ||
        (round >= ROUNDS && guide.gain() < MIN_RISE * before))
      break;
  }
  // What a few photons leave behind that media scatter hundreds of times tells less than it seems to.
  if (guide.gain() < MIN_GAIN || (scene.hasMedia() && squares < guided)) guide = {};
  guidance.secondMoment = (guide.active() ? last.guided : last.squares) / double(trial.photons);
  std::vector<float> powers;
  for (const Trials::Arrived& a : last.powers) powers.push_back(a.power);
  guidance.splitPower = splitPowerOf(std::move(powers), trial.photons);
  leaveToRays(last, guidance);
  return guidance;
}

EmissionGuide learnEmissionGuide(const Scene& scene, const PathClasses& classes, uint64_t seed, int maxDepth,
                                 const ForwardControl& control, TransportCounts& counts) {
  constexpr uint64_t TRIALS = 32768; // a round
  ShootSettings trial;
  trial.photons = TRIALS;
  trial.maxDepth = maxDepth;
  const VisibleRegion region = probeRegion(scene, {}, counts);
  return learnGuidance(scene, classes, seed, trial, region, control, counts).emission;
}

} // namespace recurse
