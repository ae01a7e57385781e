/** @file
 * Integrators: estimators of radiance, told apart by path class.
 */
#pragma once

#include <atomic>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "recurse/core/ray.h"
#include "recurse/core/sampler.h"
#include "recurse/model/scene.h"
#include "recurse/transport/estimatorDomains.h"
#include "recurse/transport/pathClasses.h"

namespace recurse {

/** Which share of the work this is: every sample is keyed by it. */
struct Pass {
  uint64_t seed = 0;
  uint32_t index = 0;
  bool only = true; ///< there is no other
};

/** What happened while rendering; counted per thread and added up. */
struct TransportCounts {
  uint64_t rays = 0;         ///< intersection and occlusion queries
  uint64_t nonFinite = 0;    ///< contributions dropped because they were not finite; must be 0
  double weightCut = 0;      ///< throughput lost to depth and weight limits, summed over eye paths
  uint64_t gathers = 0;      ///< density estimates
  uint64_t photonsFound = 0; ///< over all gathers
  void add(const TransportCounts& o) {
    rays += o.rays;
    nonFinite += o.nonFinite;
    weightCut += o.weightCut;
    gathers += o.gathers;
    photonsFound += o.photonsFound;
  }
};

/**
 * The radiance of one eye path, sorted into film layers. The only way in is to say which path it came by:
 * what the light side has read and what the eye side has read.
 */
class PathRadiance {
 public:
  PathRadiance(const PathClasses& classes, TransportCounts& counts)
      : counts(counts), classes(classes), layers(classes.layerCount(), BLACK) {}

  void reset() {
    std::fill(layers.begin(), layers.end(), BLACK);
    sum = BLACK;
  }
  /** Adds radiance that came along the path whose halves these are. Not finite: dropped and counted. */
  void add(LightState light, EyeState eye, const Rgb& radiance) {
    const LayerMask mask = classes.join(light, eye);
    if (mask == 0) return;
    if (!isFinite(radiance)) {
      ++counts.nonFinite;
      return;
    }
    sum += radiance;
    for (LayerMask rest = mask; rest != 0; rest &= rest - 1)
      layers[static_cast<size_t>(__builtin_ctzll(rest))] += radiance;
  }
  const Rgb* values() const { return layers.data(); }
  /** Everything that is in at least one layer, once. */
  const Rgb& total() const { return sum; }
  const PathClasses& pathClasses() const { return classes; }

  TransportCounts& counts;

 private:
  const PathClasses& classes;
  std::vector<Rgb> layers;
  Rgb sum{0};
};

/** What the forward pass did. */
struct ForwardStatistics {
  uint64_t photonsEmitted = 0, photonsStored = 0, photonsRefused = 0;
  double shootSeconds = 0, balanceSeconds = 0;
  size_t mapBytes = 0;
  TransportCounts counts;
  std::vector<std::string> notes;    ///< what was chosen by itself, in words
  std::vector<std::string> warnings; ///< what will be seen in the picture, in words
};

/** The forward pass reports its progress here and looks whether it should stop. */
struct ForwardControl {
  std::function<void(double fraction)> progress = [](double) {};
  const std::atomic<bool>* stop = nullptr;
  bool stopped() const { return stop && stop->load(std::memory_order_relaxed); }
};

/** An eye path to be walked: where it starts, its samples, and where its radiance goes. */
struct EyePath {
  EyePath(const Sampler& sampler, PathRadiance& out) : sampler(sampler), out(&out) {}
  EyeRay ray;
  Sampler sampler;
  PathRadiance* out;
};

/** How many eye paths are handed over at once: enough to keep the processor busy with independent work, few
 * enough for the cache next to it. */
constexpr size_t EYE_BATCH = 256;

class Integrator {
 public:
  virtual ~Integrator() = default;
  /** Called once, before the first pass. Throws Error when it cannot render the scene. */
  virtual void prepare(const Scene&, const PathClasses&) {}
  /** How many times forward() is called for so many samples a pixel (0: no end is known): 1, once for all
   * samples; n, the samples are dealt out to n passes; 0, once for each sample. */
  virtual int passes(int /*samplesPerPixel*/) const { return 1; }
  /** Shoots what the pass needs. Passes depend on no other but the first, which is always done. */
  virtual ForwardStatistics forward(const Scene&, const PathClasses&, const Pass&, const ForwardControl&) {
    return {};
  }
  /** Estimates the radiance along an eye ray. May be called from any thread for any pixel. */
  virtual void backward(const Scene& scene, const EyeRay& ray, Sampler& sampler, PathRadiance& out) const = 0;
  /** The same for several eye paths, which must share their classes; each gets the radiance that it would get
   * alone. */
  virtual void backwardBatch(const Scene& scene, std::span<EyePath> paths) const {
    for (EyePath& p : paths) backward(scene, p.ray, p.sampler, *p.out);
  }
  /** The estimators and the paths that each one takes into account. */
  virtual std::vector<EstimatorDomain> domains() const = 0;
};

} // namespace recurse
