/** @file
 * Integrators: estimators of radiance, told apart by path class.
 */
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "recurse/core/math/ray.h"
#include "recurse/core/sampling/sampler.h"
#include "recurse/model/film/splatPlane.h"
#include "recurse/model/scene/scene.h"
#include "recurse/pathclasses/pathClasses.h"
#include "recurse/transport/integrator/estimatorDomains.h"
#include "recurse/transport/integrator/passes.h"
#include "recurse/transport/integrator/pathRecorder.h"

namespace recurse {

/** Which share of the work this is: every sample is keyed by it. */
struct Pass {
  uint64_t seed = 0;
  uint32_t index = 0;
  PassSchedule schedule = PassSchedule::ONE_MAP;
  float time = 0; ///< Ray::time of its photons and, where Integrator::passHasOneTime(), of its camera rays
};

/** Radii of density estimates over the width of a pixel at their point, at the first non-delta surfaces of
 * camera paths. */
struct KernelRadii {
  static constexpr size_t BINS = 8;
  /** Estimates by ratio: below 1, then [2^(i-1), 2^i), the last without end. */
  std::array<uint64_t, BINS> bins{};
  double sumLog2 = 0; ///< of the ratios

  /** An estimate; not counted where there was no search, or the pixel's width is not known. */
  void add(float radius, float footprint) {
    const float ratio = radius / footprint;
    if (!(ratio > 0 && ratio < INFINITE)) return;
    ++bins[size_t(std::clamp(std::ilogb(ratio) + 1, 0, int(BINS) - 1))];
    sumLog2 += double(std::log2(ratio));
  }
  void add(const KernelRadii& o) {
    for (size_t i = 0; i < BINS; ++i) bins[i] += o.bins[i];
    sumLog2 += o.sumLog2;
  }
  uint64_t count() const { return std::accumulate(bins.begin(), bins.end(), uint64_t{0}); }
  /** Geometric mean of the ratios; NaN without any. */
  double mean() const { return std::exp2(sumLog2 / double(count())); }
};

/** What happened while rendering; counted per thread and added up. */
struct TransportCounts {
  uint64_t rays = 0;              ///< intersection and occlusion queries
  uint64_t nonFinite = 0;         ///< contributions dropped because they were not finite; must be 0
  double truncatedThroughput = 0; ///< throughput lost to depth and weight limits, summed over camera paths
  uint64_t gathers = 0;           ///< density estimates
  uint64_t photonsFound = 0;      ///< over all gathers
  uint64_t photonsScattered = 0;  ///< of them those whose BSDF was evaluated one by one
  KernelRadii causticRadii, otherRadii; ///< of estimates from caustic photons, and from all others
  void add(const TransportCounts& o) {
    causticRadii.add(o.causticRadii);
    otherRadii.add(o.otherRadii);
    rays += o.rays;
    nonFinite += o.nonFinite;
    truncatedThroughput += o.truncatedThroughput;
    gathers += o.gathers;
    photonsFound += o.photonsFound;
    photonsScattered += o.photonsScattered;
  }
};

/** What light paths bring straight to the eye, sorted into film layers; for any thread. A path's contribution
 * is its flux, as if it were the only one, times its scattering and the camera's importance over its density
 * (WiSample), times its weight among other techniques; the sum is divided by the number of paths. */
class Splatter {
 public:
  Splatter(const PathClasses& classes, const Filter& filter, SplatPlane& plane)
      : classes(classes), filter(filter), plane(plane) {}
  /** Adds a contribution that came along the path whose halves these are, around a place of the film. Not
   * finite: dropped and counted. */
  void add(LightState light, CameraState eye, const Vec2f& film, const Rgb& contribution,
           TransportCounts& counts) {
    const LayerMask mask = classes.join(light, eye);
    if (mask == 0 || isBlack(contribution)) return;
    if (isFinite(contribution))
      plane.add(film, filter, mask, whiteBalance ? *whiteBalance * contribution : contribution);
    else
      ++counts.nonFinite;
  }
  std::optional<Mat3f> whiteBalance; ///< of the film
  /** Counts light paths, all of them. */
  void addPaths(uint64_t count) { plane.addPaths(count); }

 private:
  const PathClasses& classes;
  const Filter& filter;
  SplatPlane& plane;
};

/**
 * The radiance of one camera path, sorted into film layers. The only way in is to say which path it came by:
 * what the light side has read and what the camera side has read.
 */
class PathRadiance {
 public:
  PathRadiance(const PathClasses& classes, TransportCounts& counts)
      : counts(counts), classes(classes), layers(classes.layerCount(), BLACK) {}

  void reset() {
    std::fill(layers.begin(), layers.end(), BLACK);
    sum = seen = BLACK;
  }
  /** Puts `change(colour)` in the place of all that was added; must be linear. */
  template <class Change> void transform(const Change& change) {
    for (Rgb& layer : layers) layer = change(layer);
    sum = change(sum);
    seen = change(seen);
  }
  /** Multiplies all that was added. */
  void scale(float factor) {
    for (Rgb& layer : layers) layer *= factor;
    sum *= factor;
    seen *= factor;
  }
  /** Adds radiance that came along the path whose halves these are. Not finite: dropped and counted. */
  void add(LightState light, CameraState eye, const Rgb& radiance) {
    const LayerMask mask = classes.join(light, eye);
    if (mask == 0) return;
    if (!isFinite(radiance)) {
      ++counts.nonFinite;
      return;
    }
    if (recorder) [[unlikely]]
      recorder->add(mask, radiance);
    sum += radiance;
    for (LayerMask rest = mask; rest != 0; rest &= rest - 1)
      layers[static_cast<size_t>(__builtin_ctzll(rest))] += radiance;
  }
  /** The same for LS*E: light that the eye sees, and nothing has scattered. */
  void addSeen(CameraState eye, const Rgb& radiance) {
    add(classes.lightStart(), eye, radiance);
    if (classes.join(classes.lightStart(), eye) != 0 && isFinite(radiance)) seen += radiance;
  }
  const Rgb* values() const { return layers.data(); }
  /** Everything that is in at least one layer, once. */
  const Rgb& total() const { return sum; }
  /** What of it was scattered, by integrators that tell it apart. */
  Rgb scattered() const { return sum - seen; }
  const PathClasses& pathClasses() const { return classes; }
  /** Asked in loops that may be long: the sample is not wanted any more, and what was added does not count.
   */
  bool abandoned() const { return abandon && abandon->load(std::memory_order_relaxed); }

  TransportCounts& counts;
  const std::atomic<bool>* abandon = nullptr; ///< see abandoned(); null: never
  PathRecorder* recorder = nullptr;           ///< of this camera path; null: nothing is recorded

 private:
  const PathClasses& classes;
  std::vector<Rgb> layers;
  Rgb sum{0}, seen{0};
};

/** What the forward pass did. */
struct ForwardStatistics {
  uint64_t photonsEmitted = 0, photonsStored = 0, photonsRefused = 0;
  double shootSeconds = 0, balanceSeconds = 0;
  double learningSeconds = 0; ///< processor time of what is done once, for all passes
  size_t mapBytes = 0;
  TransportCounts counts;
  std::vector<std::string> notes;    ///< what was chosen by itself, in words
  std::vector<std::string> warnings; ///< what will be seen in the picture, in words
};

/** Processes that make the same pass at the same time, and share its photons. */
class PhotonSharing {
 public:
  virtual ~PhotonSharing() = default;
  /**
   * Called by all: calls shoot(first, end) for the batches out of `count` that fall to this process, then
   * use(batch, bytes) for each of the others with what shot(batch) returned where it was shot. False where it
   * was stopped somewhere: nothing is to be used.
   */
  virtual bool share(size_t count, const std::function<void(size_t first, size_t end)>& shoot,
                     const std::function<std::vector<std::byte>(size_t batch)>& shot,
                     const std::function<void(size_t batch, std::span<const std::byte>)>& use) = 0;
};

/** The forward pass reports its progress here and looks whether it should stop. */
struct ForwardControl {
  std::function<void(double fraction)> progress = [](double) {};
  const std::atomic<bool>* stop = nullptr;
  /** Where Integrator::splats(): for this pass's light paths; null for a pass whose splats are there. */
  Splatter* splatter = nullptr;
  PhotonSharing* sharing = nullptr; ///< null: all photons are shot here
  bool stopped() const { return stop && stop->load(std::memory_order_relaxed); }
};

/** A camera path to be walked: where it starts, its samples, and where its radiance goes. */
struct CameraPath {
  CameraPath(const Sampler& sampler, PathRadiance& out) : sampler(sampler), out(&out) {}
  CameraRay ray;
  Sampler sampler;
  PathRadiance* out;
};

/** How many camera paths are handed over at once: enough to keep the processor busy with independent work,
 * few enough for the cache next to it. */
constexpr size_t CAMERA_BATCH = 256;

/** A photon of a map. */
struct StoredPhoton {
  Vec3f position;  ///< [scene units], relative to Scene::origin()
  Vec3f direction; ///< unit, towards where it came from
  Vec3f normal;    ///< geometric, unit, on the side that it came from
  Rgb power;       ///< flux [W]
  LightState state;
  bool caustic = false; ///< of a map of caustics, where there is one
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  /** Called once, before the first pass. Throws Error when it cannot render the scene. */
  virtual void prepare(const Scene&, const PathClasses&) {}
  /** How often forward() is called for so many samples of each pixel; 0: no end is known. */
  virtual Passes passes(int /*samplesPerPixel*/) const { return Passes::oneMap(); }
  /** Whether light paths bring something to pixels by themselves, through a Splatter in forward(). */
  virtual bool splats() const { return false; }
  /** How many photons forward() emits each time; 0: it keeps none in a map. */
  virtual uint64_t photonsEmitted(const Scene&) const { return 0; }
  /** Whether a pass's camera rays have the time of its photons, so that no estimate mixes times. */
  virtual bool passHasOneTime() const { return false; }
  /** Shoots what the pass needs. Passes depend on no other but the first, which is always done. */
  virtual ForwardStatistics forward(const Scene&, const PathClasses&, const Pass&, const ForwardControl&) {
    return {};
  }
  /** Estimates the radiance along a camera ray. May be called from any thread for any pixel. */
  virtual void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                        PathRadiance& out) const = 0;
  /** The same for several camera paths, which must share their classes; each gets the radiance that it would
   * get alone. */
  virtual void backwardBatch(const Scene& scene, std::span<CameraPath> paths) const {
    for (CameraPath& p : paths) backward(scene, p.ray, p.sampler, *p.out);
  }
  /** Calls visit(photon) for each photon at a surface that the latest forward() has left in a map. */
  virtual void visitPhotons(const std::function<void(const StoredPhoton&)>& /*visit*/) const {}
  /** Whether it renders the media of the scene. */
  virtual bool supportsMedia(const Scene&) const { return false; }
  /** Whether it renders what is made of a FIBRE: both ends of a path do not agree on its densities. */
  virtual bool supportsFibres() const { return true; }
  /** The estimators and the paths that each one takes into account; where the scene decides between
   * choices(), those of what the first pass has chosen. */
  virtual std::vector<EstimatorDomain> domains() const = 0;
  /** What the first pass chooses from by the scene, in words; empty: nothing is chosen. */
  virtual std::string choices() const { return {}; }
  /** The paths that the method claims, where it leaves out others by its nature; empty: all at surfaces. */
  virtual std::string claims() const { return {}; }
  /** What the method takes for granted of these paths though the scene says otherwise, in words; empty:
   * nothing. */
  virtual std::string suppositions() const { return {}; }
};

/** What of the scene the integrator does not render, in words; empty: nothing. */
inline std::string unsupportedPart(const Integrator& integrator, const Scene& scene) {
  if (scene.hasMedia() && !integrator.supportsMedia(scene)) return "media such as those of the scene";
  if ((scene.contents().lobes & FIBRE) && !integrator.supportsFibres()) return "hair";
  return {};
}

/** Memory that a map of this many stored photons takes while it is built [bytes]: the photons in the order of
 * their emission, and in that of the tree. */
double photonMapBytes(double stored);

} // namespace recurse
