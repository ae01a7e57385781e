/** @file
 * Photon walks.
 */
#include "recurse/transport/shoot.h"

#include <algorithm>
#include <mutex>

#include "recurse/core/parallel.h"
#include "recurse/model/scatteringPoint.h"
#include "recurse/transport/walk.h"

namespace recurse {

namespace {

/** Tells photon samples from those of pixels. */
constexpr uint64_t PHOTON_STREAM = 0x50484f544f4e53ull, TRIAL_STREAM = 0x545249414c53ull;
constexpr uint64_t BATCH = 4096;

class PhotonWalk {
 public:
  PhotonWalk(const Scene& scene, const PathClasses& classes, const ShootSettings& settings,
             TransportCounts& counts, std::vector<Photon>& out)
      : scene(scene), classes(classes), settings(settings), counts(counts), out(out) {}

  /** Returns what the photon started by, and one over its density. */
  EmissionGuide::Useful shoot(Sampler sampler) {
    const float light = sampler.next1D(), part = sampler.next1D();
    const Vec2f place = sampler.next2D(), direction = sampler.next2D();
    EmissionGuide::Useful start{{light, part, place.x, place.y, direction.x, direction.y}, 1};
    auto& n = start.numbers;
    if (settings.guide && settings.guide->active())
      start.weight = 1 / settings.guide->warp(n, sampler.next1D());
    float pick = n[0];
    const ChosenLight chosen = scene.lights().choose(pick);
    if (!(chosen.probability > 0)) return start;
    const std::optional<Emission> emission = chosen.light->emit({n[1], {n[2], n[3]}, {n[4], n[5]}});
    if (emission && !isBlack(emission->flux))
      walk(*emission,
           emission->flux * (start.weight / (chosen.probability * static_cast<float>(settings.photons))),
           sampler);
    return start;
  }

 private:
  void walk(const Emission& emission, Rgb flux, Sampler& sampler) {
    if (!recurse::isFinite(flux)) {
      ++counts.nonFinite;
      return;
    }
    LightState state = classes.lightStart();
    if (classes.dead(state)) return;
    Ray ray{emission.origin, emission.direction, INFINITE};
    Nesting nesting = nestingAt(scene, ray, counts);
    Hit hit;
    bool caustic = true;
    for (int depth = 0;;) {
      if (!intersect(scene, ray, hit, counts)) return;
      arena.reset();
      const Bsdf* bsdf = bsdfAt(scene, hit, ray.direction, Footprint(), nesting, arena);
      if (!bsdf) {
        ray = spawn(hit.point, ray.direction);
        continue;
      }
      if (depth == settings.maxDepth) {
        counts.weightCut += double(maxComponent(flux));
        return;
      }
      const ScatteringPoint scattering(*bsdf, hit.point);
      const Vec3f wi = -ray.direction;
      const LightState stateD = classes.step(state, PathEvent::D), stateS = classes.step(state, PathEvent::S);
      if (scattering.hasDiffuse() && !classes.dead(stateD) && (depth > 0 || settings.direct))
        store(hit.point, scattering, wi, flux, state, caustic);
      ++depth;
      const LobeSet allowed = LobeSet((classes.dead(stateD) ? NO_LOBE : DIFFUSE_LOBES) |
                                      (classes.dead(stateS) ? NO_LOBE : DELTA_LOBES));
      const std::optional<Scatter> s = scattering.scatter(wi, Transport::FLUX, sampler, allowed);
      if (!s) return;
      const Rgb scattered = flux * s->weight;
      const float before = maxComponent(flux), after = maxComponent(scattered);
      flux = scattered;
      if (!survives(std::min(1.0f, after / before), depth, sampler, flux)) return;
      state = s->specular() ? stateS : stateD;
      nesting.scatters(hit, wi, s->direction);
      caustic = caustic && s->specular();
      ray = spawn(hit.point, s->direction);
    }
  }

  /** Rounding must not send a photon that only grazes the surface below it, where no search would find it. */
  static PackedDirection packOnSide(const Vec3f& wi, const Vec3f& normal) {
    PackedDirection packed = packDirection(wi);
    const float cosine = glm::dot(wi, normal);
    if (std::abs(cosine) > 1e-4f) return packed; // packing turns it by less
    const Vec3f up = normal * std::copysign(1.0f, cosine);
    for (float lift = 4e-5f; glm::dot(unpackDirection(packed), up) < 1e-6f; lift *= 2)
      packed = packDirection(glm::normalize(wi + up * lift));
    return packed;
  }

  void store(const SurfacePoint& point, const ScatteringPoint& scattering, const Vec3f& wi, const Rgb& flux,
             LightState state, bool caustic) {
    const float geometric = absDot(wi, point.geometricNormal);
    if (geometric == 0) return; // in the plane of the surface: brings no flux
    Photon p;
    p.position = point.position;
    p.direction = packOnSide(wi, point.geometricNormal);
    p.power = flux * (absDot(wi, scattering.normal()) / geometric);
    p.pathState = state.byte;
    p.caustic = caustic;
    out.push_back(p);
  }

  const Scene& scene;
  const PathClasses& classes;
  const ShootSettings& settings;
  TransportCounts& counts;
  std::vector<Photon>& out;
  BsdfArena arena;
};

} // namespace

ShotPhotons shootPhotons(const Scene& scene, const PathClasses& classes, const Pass& pass,
                         const ShootSettings& settings, const ForwardControl& control) {
  ShotPhotons shot;
  if (scene.lights().size() == 0 || settings.photons == 0) return shot;
  const size_t batches = (settings.photons + BATCH - 1) / BATCH;
  std::vector<std::vector<Photon>> stored(batches);
  std::vector<TransportCounts> counts(batches);
  std::atomic<size_t> done{0};
  std::mutex telling;
  parallelFor(batches, [&](size_t b) {
    if (control.stopped()) return;
    PhotonWalk walk(scene, classes, settings, counts[b], stored[b]);
    const uint64_t end = std::min(settings.photons, (b + 1) * BATCH);
    for (uint64_t i = b * BATCH; i < end; ++i)
      walk.shoot(
          Sampler(hashCombine(pass.seed, pass.index), PHOTON_STREAM + (i >> 32), static_cast<uint32_t>(i)));
    const size_t n = ++done;
    if (telling.try_lock()) {
      control.progress(static_cast<double>(n) / static_cast<double>(batches));
      telling.unlock();
    }
  });
  size_t total = 0;
  for (const auto& s : stored) total += s.size();
  shot.stored.reserve(total);
  for (auto& s : stored) {
    shot.stored.insert(shot.stored.end(), s.begin(), s.end());
    std::vector<Photon>().swap(s);
  }
  for (const TransportCounts& c : counts) shot.counts.add(c);
  shot.emitted = settings.photons;
  return shot;
}

EmissionGuide learnEmission(const Scene& scene, const PathClasses& classes, uint64_t seed,
                            const ShootSettings& settings, const VisibleRegion& region,
                            const ForwardControl& control, TransportCounts& counts) {
  constexpr uint64_t TRIALS = 8 * BATCH;
  constexpr int ROUNDS = 5;
  constexpr double WORTH_IT = 1.5;
  EmissionGuide guide;
  if (scene.lights().size() == 0 || region.empty()) return guide;
  ShootSettings trial = settings;
  // No more than a pass has: learning must not cost many times what it serves.
  const uint64_t trials = trial.photons = std::min(TRIALS, settings.photons);
  std::vector<EmissionGuide::Useful> useful;
  for (int round = 0; round < ROUNDS && !control.stopped(); ++round) {
    trial.guide = &guide;
    std::array<std::vector<EmissionGuide::Useful>, TRIALS / BATCH> found;
    std::array<TransportCounts, TRIALS / BATCH> batchCounts;
    parallelFor(found.size(), [&](size_t b) {
      std::vector<Photon> stored;
      PhotonWalk walk(scene, classes, trial, batchCounts[b], stored);
      for (uint64_t i = b * BATCH; i < std::min(trials, (b + 1) * BATCH); ++i) {
        stored.clear();
        const EmissionGuide::Useful start =
            walk.shoot(Sampler(hashCombine(seed, uint64_t(round)), TRIAL_STREAM, static_cast<uint32_t>(i)));
        if (std::any_of(stored.begin(), stored.end(),
                        [&](const Photon& p) { return region.contains(p.position); }))
          found[b].push_back(start);
      }
    });
    for (const auto& f : found) useful.insert(useful.end(), f.begin(), f.end());
    for (const TransportCounts& c : batchCounts) counts.add(c);
    guide = EmissionGuide(useful, double(trials) * (round + 1));
    // Few hits say little yet; many of a density that is good already, that there is no more to gain.
    if (useful.size() > trials / 4 && guide.gain() < WORTH_IT) break;
  }
  return guide.gain() < WORTH_IT ? EmissionGuide() : guide;
}

} // namespace recurse
