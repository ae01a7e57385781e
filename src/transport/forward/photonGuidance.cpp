/** @file
 * Learning of the emission guide, the DXTRAN spheres and the splitting power from trial photons.
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

/** Sampler stream of trial photons, distinct from the streams of photons and pixels. */
constexpr uint64_t TRIAL_STREAM = 0x545249414c53ull;

/** DXTRAN spheres that cover the visible points, except groups that are too wide or have too few points. */
std::vector<DxtranSphere> dxtranSpheresAround(const Scene& scene, std::vector<Vec3f> seen,
                                              std::span<const Vec3f> landed) {
  constexpr float MAX_RADIUS = 0.2f; // maximum radius over the scene's radius
  constexpr double MIN_COUNT = 0.02; // minimum fraction of the visible points
  constexpr float SPARED = 8;        // factor on the power of photons sent to a sphere: divides their number
  constexpr size_t MAX_COUNT = 8;
  struct Part {
    std::span<Vec3f> places;
    Bounds3f box;
    float radius() const { return glm::length(box.diagonal()) / 2; }
  };
  const auto partOf = [](std::span<Vec3f> places) {
    Part part{places, {}};
    for (const Vec3f& p : places) part.box.add(p);
    return part;
  };
  std::vector<Part> parts{partOf(seen)};
  while (parts.size() < MAX_COUNT) {
    // Cuts the part whose points would gain most: the one with the largest radius² times number of points.
    const auto cut = std::max_element(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
      return square(a.radius()) * static_cast<float>(a.places.size()) <
             square(b.radius()) * static_cast<float>(b.places.size());
    });
    const int axis = widestAxis(cut->box.diagonal());
    const float at = cut->box.center()[axis];
    const auto middle =
        std::partition(cut->places.begin(), cut->places.end(), [&](const Vec3f& p) { return p[axis] < at; });
    const auto left = static_cast<size_t>(middle - cut->places.begin());
    if (left == 0 || left == cut->places.size()) break;
    const Part right = partOf(cut->places.subspan(left));
    *cut = partOf(cut->places.first(left));
    parts.push_back(right);
  }
  std::vector<DxtranSphere> targets;
  for (const Part& part : parts) {
    const float radius = part.radius();
    const double share = double(part.places.size()) / double(seen.size());
    if (share < MIN_COUNT || !(radius > 0 && radius < MAX_RADIUS * scene.bounds().radius)) continue;
    const Vec3f center = part.box.center();
    // Median fraction of the flux scattered by a grey surface that reaches the sphere.
    std::vector<float> typical;
    for (const Vec3f& p : landed)
      if (const float q = square(radius) / lengthSquared(p - center); q < 1 / square(NEAR_TARGET))
        typical.push_back(0.5f * (1 - std::sqrt(1 - q)));
    if (typical.empty()) continue;
    const auto middle = typical.begin() + static_cast<std::ptrdiff_t>(typical.size() / 2);
    std::nth_element(typical.begin(), middle, typical.end());
    targets.push_back({center, radius, SPARED * *middle / static_cast<float>(share),
                       static_cast<float>(part.places.size()) / square(radius)});
  }
  return targets;
}

/** Sums over trial photons. */
struct Trials {
  std::vector<EmissionGuide::TrainingSample> useful;
  /** Trial photons that were stored in the visible region. */
  struct Arrived {
    float power;                   ///< power if only one photon was emitted [W]
    float startDensity, fullPower; ///< see PhotonWalk; `fullPower` scaled like `power`
  };
  std::vector<Arrived> powers;
  std::vector<Vec3f> landed; ///< positions of a sample of the stored photons
  uint64_t stored = 0, inRegion = 0, sent = 0, arrived = 0;
  double squares = 0, guided = 0; ///< second moments of contributions: unguided, and with the guide in use
  TransportCounts counts;
  /** Whether enough of the photons sent to the targets arrive there for targets to be useful. */
  bool arrive() const {
    constexpr double MIN_ARRIVED = 0.2;
    return double(arrived) >= MIN_ARRIVED * double(sent);
  }
  void add(const Trials& o) {
    useful.insert(useful.end(), o.useful.begin(), o.useful.end());
    landed.insert(landed.end(), o.landed.begin(), o.landed.end());
    powers.insert(powers.end(), o.powers.begin(), o.powers.end());
    stored += o.stored;
    inRegion += o.inRegion;
    sent += o.sent;
    arrived += o.arrived;
    squares += o.squares;
    guided += o.guided;
    counts.add(o.counts);
  }
};

/** Power above which photons are split; large enough that splitting adds no more photons than are emitted.
 */
float splitPowerOf(std::vector<float> powers, uint64_t emitted) {
  constexpr float OVER_TYPICAL = 2;
  if (powers.empty()) return INFINITE;
  const auto middle = powers.begin() + static_cast<std::ptrdiff_t>(powers.size() / 2);
  std::nth_element(powers.begin(), middle, powers.end());
  const double sum = std::accumulate(powers.begin(), powers.end(), 0.0);
  return std::max(OVER_TYPICAL * *middle, static_cast<float>(sum / double(emitted)));
}

/** Sets the emission density below which rays replace photons of infinite lights after the first surface. */
void leaveToRays(const Trials& trials, PhotonGuidance& guidance) {
  constexpr float MAX_POWER = 32; // in splitting powers: a stronger photon is visible as a blotch
  constexpr double WORTH_IT = 4;  // minimum reduction of the photons' variance that outweighs noise of rays
  double starts = 0, far = 0;
  for (const Trials::Arrived& a : trials.powers) {
    if (!(a.startDensity < INFINITE)) continue;
    starts += double(a.startDensity) * double(a.fullPower);
    ++far;
  }
  if (!(starts > 0)) return;
  // Infinite lights are chosen by power, so density times power is nearly the same for all starts.
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

Trials shootTrials(const Scene& scene, const PathClasses& classes, uint64_t seed,
                   const ShootSettings& settings, const VisibleRegion& region) {
  const size_t batches = (settings.photons + PHOTON_BATCH - 1) / PHOTON_BATCH;
  std::vector<Trials> parts(batches);
  parallelFor(batches, [&](size_t b) {
    Trials& part = parts[b];
    StoredPhotons stored;
    PhotonWalk walk(scene, classes, settings, part.counts, stored);
    walk.region = &region;
    for (uint64_t i = b * PHOTON_BATCH; i < std::min(settings.photons, (b + 1) * PHOTON_BATCH); ++i) {
      stored.clear();
      Sampler sampler(seed, TRIAL_STREAM, static_cast<uint32_t>(i));
      const float time =
          scene.moves() ? scene.camera().timeAt(sampler.next1D()) : 0; // one guide serves all times
      EmissionGuide::TrainingSample start = walk.shoot(sampler, time);
      // A photon that enters a target at full power counts with that power there, whatever its later path.
      const double perPhoton = double(settings.photons) / double(start.weight);
      auto squares =
          double(walk.enteredImportance()) * square(double(walk.fullPower()) * double(settings.photons));
      for (const Photon& p : stored.onSurfaces) {
        const auto importance = double(region.importance(p.position));
        if (importance == 0) continue;
        ++part.inRegion;
        part.powers.push_back({maxComponent(p.power) * static_cast<float>(settings.photons),
                               walk.startDensity(), walk.fullPower() * static_cast<float>(settings.photons)});
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
      part.stored += stored.size();
      if (!stored.onSurfaces.empty() && i % 16 == 0) part.landed.push_back(stored.onSurfaces[0].position);
      part.squares += double(start.weight) * squares;
      part.guided += square(double(start.weight)) * squares;
      start.weight *= static_cast<float>(squares);
      if (start.weight > 0) part.useful.push_back(start);
    }
    part.sent = walk.sent;
    part.arrived = walk.arrived;
  });
  Trials all;
  for (const Trials& t : parts) all.add(t);
  return all;
}

} // namespace

PhotonGuidance learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                             const ShootSettings& settings, const VisibleRegion& region,
                             const ForwardControl& control, TransportCounts& counts, GuidanceChoice choice) {
  constexpr uint64_t TRIALS = 8 * PHOTON_BATCH;
  constexpr int ROUNDS = 5, MAX_ROUNDS = 16;
  constexpr double MIN_RISE = 1.1, MIN_GAIN = 1.5;
  constexpr double MAX_IN_REGION = 0.05; // fraction of the stored photons above which no targets are needed
  PhotonGuidance guidance;
  if (scene.lights().size() == 0 || region.empty()) return guidance;
  EmissionGuide& guide = guidance.emission;
  ShootSettings trial = settings;
  trial.guide = &guide;
  // At most the photons of one pass, so that learning never costs many times as much as its use.
  trial.photons = std::min(TRIALS, settings.photons);
  uint64_t shot = 0;
  double squares = 0, guided = 0; // sums over all rounds with a guide, each learned from earlier rounds
  // Shoots rounds of trials until the guide stops improving. Returns the last round.
  const auto learn = [&] {
    guide = {};
    std::vector<EmissionGuide::TrainingSample> useful;
    for (int round = 1;; ++round) {
      const Trials trials = shootTrials(scene, classes, hashCombine(seed, shot++), trial, region);
      counts.add(trials.counts);
      if (shot == 1) guidance.useful = trials.inRegion;
      if (round > 1) squares += trials.squares;
      if (round > 1) guided += trials.guided;
      if (!trial.targets.empty() && !trials.arrive()) return trials;
      useful.insert(useful.end(), trials.useful.begin(), trials.useful.end());
      const double before = guide.gain();
      if (choice.emission)
        guide = EmissionGuide(useful, double(trial.photons) * round, scene.lights().size());
      // Few hits are unreliable; many hits of an already good density mean that there is no more to gain.
      double weight = 0, squared = 0;
      for (const EmissionGuide::TrainingSample& u : useful) {
        weight += double(u.weight);
        squared += square(double(u.weight));
      }
      const bool wellKnown = square(weight) > squared * double(trial.photons) / 4;
      if (control.stopped() || (wellKnown && guide.gain() < MIN_GAIN) || round == MAX_ROUNDS ||
          (round >= ROUNDS && guide.gain() < MIN_RISE * before))
        return trials;
    }
  };
  Trials last = learn();
  if (choice.targets && double(last.inRegion) < MAX_IN_REGION * double(last.stored) && !control.stopped()) {
    const EmissionGuide without = guide;
    trial.targets = dxtranSpheresAround(scene, region.all(), last.landed);
    if (!trial.targets.empty()) {
      if (Trials sent = learn(); sent.arrive()) {
        last = std::move(sent);
      } else {
        trial.targets.clear();
        guide = without;
      }
    }
  }
  // A few photons that scatter hundreds of times in media overestimate the gain of a guide.
  if (guide.gain() < MIN_GAIN || (scene.hasMedia() && squares < guided)) guide = {};
  guidance.secondMoment = (guide.active() ? last.guided : last.squares) / double(trial.photons);
  guidance.targets = trial.targets;
  std::vector<float> powers;
  for (const Trials::Arrived& a : last.powers) powers.push_back(a.power);
  guidance.splitPower = splitPowerOf(std::move(powers), trial.photons);
  leaveToRays(last, guidance);
  return guidance;
}

EmissionGuide learnEmissionGuide(const Scene& scene, const PathClasses& classes, uint64_t seed, int maxDepth,
                                 const ForwardControl& control, TransportCounts& counts, uint64_t trials) {
  ShootSettings trial;
  trial.photons = trials;
  trial.maxDepth = maxDepth;
  const VisibleRegion region = probeRegion(scene, {}, counts);
  return learnGuidance(scene, classes, seed, trial, region, control, counts, {.targets = false}).emission;
}

} // namespace recurse
