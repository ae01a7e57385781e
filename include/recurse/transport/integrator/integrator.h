/** @file
 * Integrators: estimators of radiance, separated by path class.
 */
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "recurse/core/math/ray.h"
#include "recurse/core/sampling/sampler.h"
#include "recurse/model/bsdf/directionGuide.h"
#include "recurse/model/film/splatPlane.h"
#include "recurse/model/scene/scene.h"
#include "recurse/pathclasses/pathClasses.h"
#include "recurse/transport/integrator/estimatorDomains.h"
#include "recurse/transport/integrator/lightPathRecorder.h"
#include "recurse/transport/integrator/passes.h"
#include "recurse/transport/integrator/pathRecorder.h"

namespace recurse {

/** Identity of a pass, from which all its samples are seeded. */
struct Pass {
  uint64_t seed = 0;
  uint32_t index = 0;
  PassSchedule schedule = PassSchedule::ONE_MAP;
  float time = 0; ///< Ray::time of its photons and, where Integrator::passHasOneTime(), of its camera rays
};

/** Ratios of the kernel radius of a density estimate to the footprint (width) of the pixel there, at the
 * first non-delta vertices of camera paths. */
struct KernelRadii {
  static constexpr size_t BINS = 8;
  /** Number of estimates by ratio: below 1, then [2^(i-1), 2^i), the last bin without upper limit. */
  std::array<uint64_t, BINS> bins{};
  double sumLog2 = 0; ///< sum over log2 of the ratios

  /** Adds an estimate; ignored where there was no search, or the footprint is unknown. */
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
  /** Geometric mean of the ratios; NaN without estimates. */
  double mean() const { return std::exp2(sumLog2 / double(count())); }
};

/** Smallest and largest of the lengths that were added; `least` > `most` before the first. */
struct LengthRange {
  float least = INFINITE, most = -INFINITE; ///< [scene units]
  bool empty() const { return least > most; }
  void add(const LengthRange& o) {
    least = std::min(least, o.least);
    most = std::max(most, o.most);
  }
  void add(float length) { add(LengthRange{length, length}); }
};

/** Counters of a render, kept for each thread and then added. */
struct TransportCounts {
  uint64_t rays = 0;         ///< intersection and occlusion queries
  uint64_t boundaryRays = 0; ///< number of these that searched for the boundary of a surface within a kernel
  uint64_t nonFinite = 0;    ///< contributions dropped because they were not finite; must be 0
  /** Largest channel of the throughput lost to depth and weight limits, summed over camera paths. */
  double truncatedThroughput = 0;
  uint64_t gathers = 0;                 ///< density estimates
  uint64_t photonsFound = 0;            ///< over all gathers
  uint64_t photonsScattered = 0;        ///< number of these whose BSDF was evaluated one by one
  KernelRadii causticRadii, otherRadii; ///< of estimates from caustic photons, and from all other photons
  LengthRange lengths;                  ///< optical lengths of paths with light, in transient renders only
  void add(const TransportCounts& o) {
    causticRadii.add(o.causticRadii);
    otherRadii.add(o.otherRadii);
    lengths.add(o.lengths);
    rays += o.rays;
    boundaryRays += o.boundaryRays;
    nonFinite += o.nonFinite;
    truncatedThroughput += o.truncatedThroughput;
    gathers += o.gathers;
    photonsFound += o.photonsFound;
    photonsScattered += o.photonsScattered;
  }
};

/** Splats of light paths to the camera, sorted into film layers; for any thread. The contribution of a path
 * is its flux, as if it were the only path, times its scattering, the camera's importance over its density
 * (WiSample), and its MIS weight; the sum is divided by the number of paths. */
class Splatter {
 public:
  Splatter(const PathClasses& classes, const Filter& filter, SplatPlane& plane)
      : classes(classes), filter(filter), plane(plane) {}
  /** Adds a contribution of the path that consists of these halves, around a point of the film. `length`:
   * optical length of the whole path [scene units], for transient renders only. A contribution that is not
   * finite is dropped and counted. */
  void add(LightState light, CameraState eye, const Vec2f& film, const Rgb& contribution, float length,
           TransportCounts& counts) {
    const LayerMask mask = classes.join(light, eye);
    if (mask == 0 || isBlack(contribution)) return;
    if (!isFinite(contribution)) {
      ++counts.nonFinite;
      return;
    }
    if (classes.isTransient()) [[unlikely]]
      counts.lengths.add(length);
    plane.add(film, filter, mask, whiteBalance ? *whiteBalance * contribution : contribution,
              classes.isTransient() ? classes.layerOfLength(length) : SplatPlane::NO_LAYER);
  }
  std::optional<Mat3f> whiteBalance; ///< white balance of the film
  /** Counts light paths, with or without contributions. */
  void addPaths(uint64_t count) { plane.addPaths(count); }

 private:
  const PathClasses& classes;
  const Filter& filter;
  SplatPlane& plane;
};

/**
 * Radiance of one camera path, sorted into film layers. Each contribution is added with its path: the states
 * of the light side and of the camera side.
 */
class PathRadiance {
 public:
  PathRadiance(const PathClasses& classes, TransportCounts& counts)
      : counts(counts), classes(classes), layers(classes.layerCount(), Rgbd(0)) {}

  void reset() {
    std::fill(layers.begin(), layers.end(), Rgbd(0));
    sum = seen = Rgbd(0);
  }
  /** Replaces all added radiance by `change(colour)`, which must be linear. */
  template <class Change> void transform(const Change& change) {
    const auto apply = [&](Rgbd& colour) { colour = Rgbd(change(Rgb(colour))); };
    for (Rgbd& layer : layers) apply(layer);
    apply(sum);
    apply(seen);
  }
  /** Multiplies all added radiance by `factor`. */
  void scale(float factor) {
    for (Rgbd& layer : layers) layer *= double(factor);
    sum *= double(factor);
    seen *= double(factor);
  }
  /** Adds radiance of the path that consists of these halves; dropped and counted if not finite. `length`:
   * optical length of the whole path [scene units], for transient renders only. */
  void add(LightState light, CameraState eye, const Rgb& radiance, float length = 0) {
    const LayerMask mask = classes.join(light, eye);
    if (mask == 0) return;
    if (!isFinite(radiance)) {
      ++counts.nonFinite;
      return;
    }
    if (recorder) [[unlikely]]
      recorder->add(mask, radiance);
    const Rgbd added(radiance);
    sum += added;
    for (LayerMask rest = mask; rest != 0; rest &= rest - 1)
      layers[static_cast<size_t>(__builtin_ctzll(rest))] += added;
    if (classes.isTransient()) [[unlikely]] {
      layers[classes.layerOfLength(length)] += added;
      if (!isBlack(radiance)) counts.lengths.add(length);
    }
  }
  /** Adds radiance of LS*E paths: light seen by the camera without non-delta scattering. */
  void addSeen(LightState light, CameraState eye, const Rgb& radiance, float length = 0) {
    add(light, eye, radiance, length);
    if (classes.join(light, eye) != 0 && isFinite(radiance)) seen += Rgbd(radiance);
  }
  /** Radiance by film layer. */
  std::span<const Rgbd> values() const { return layers; }
  /** Sum of all radiance in at least one layer, counted once. */
  Rgb total() const { return Rgb(sum); }
  /** Scattered part of total(), if the integrator calls addSeen(). */
  Rgb scattered() const { return Rgb(sum - seen); }
  const PathClasses& pathClasses() const { return classes; }
  /** True when the sample is not wanted any more, and its radiance will be discarded. To be polled in long
   * loops. */
  bool abandoned() const { return abandon && abandon->load(std::memory_order_relaxed); }

  TransportCounts& counts;
  const std::atomic<bool>* abandon = nullptr; ///< flag of abandoned(); null: never
  PathRecorder* recorder = nullptr;           ///< recorder of this camera path; null: nothing is recorded

 private:
  const PathClasses& classes;
  std::vector<Rgbd> layers; ///< in double precision: an estimate may add thousands of photons one by one
  Rgbd sum{0}, seen{0};
};

/** Statistics of a forward pass. */
struct ForwardStatistics {
  /** Light paths traced, and photons, virtual lights or light vertices stored, in this process. */
  uint64_t photonsEmitted = 0, photonsStored = 0;
  /** Photons that are not finite or too large, in the maps of this process, which include shared photons. */
  uint64_t photonsRefused = 0;
  double shootSeconds = 0, balanceSeconds = 0; ///< [s]
  double learningSeconds = 0; ///< processor time of learning, whose results serve later passes, too [s]
  size_t mapBytes = 0;        ///< memory of the photon maps
  std::optional<GuideStatistics> guide; ///< guide of this pass's camera paths; empty: none
  TransportCounts counts;
  std::vector<std::string> notes;    ///< automatic choices, in words
  std::vector<std::string> warnings; ///< visible consequences for the picture, in words
};

/** Exchange of photons between processes that run the same pass at the same time. */
class PhotonSharing {
 public:
  virtual ~PhotonSharing() = default;
  /**
   * Called by all processes: calls shoot(first, end) for the batches out of `count` assigned to this process,
   * then use(batch, bytes) for each remaining batch with the result of shot(batch) in the process that shot
   * it. Returns false if any process was stopped; then no result may be used.
   */
  virtual bool share(size_t count, const std::function<void(size_t first, size_t end)>& shoot,
                     const std::function<std::vector<std::byte>(size_t batch)>& shot,
                     const std::function<void(size_t batch, std::span<const std::byte>)>& use) = 0;
};

/** Progress report and stop flag of a forward pass. */
struct ForwardControl {
  /** `fraction`: in [0, 1]. Called from any thread, one at a time; may begin again within a pass. */
  std::function<void(double fraction)> progress = [](double) {};
  const std::atomic<bool>* stop = nullptr; ///< the pass ends early, incomplete, when it is true; null: never
  /** For this pass's light paths, if Integrator::splats(); null for a pass whose splats exist already. */
  Splatter* splatter = nullptr;
  PhotonSharing* sharing = nullptr;        ///< null: all photons are shot here
  LightPathRecorder* lightPaths = nullptr; ///< recorder of this pass's light paths; null: nothing is recorded
  bool stopped() const { return stop && stop->load(std::memory_order_relaxed); }
};

/** Camera path to be traced: its ray, its samples, and the destination of its radiance. */
struct CameraPath {
  CameraPath(const Sampler& sampler, PathRadiance& out) : sampler(sampler), out(&out) {}
  /** Makes the sampler in place: loads of a copy would wait for the stores of the original. */
  CameraPath(const PixelSampler& points, const PixelSample& sample, PathRadiance& out)
      : sampler(points.sampler(sample)), out(&out) {}
  CameraRay ray;
  Sampler sampler;
  PathRadiance* out;
};

/** Number of camera paths in a batch: enough independent work to keep the processor busy, and few enough for
 * its nearest cache. */
constexpr size_t CAMERA_BATCH = 256;

/** Photon of a map. */
struct StoredPhoton {
  Vec3f position;  ///< [scene units], relative to Scene::origin()
  Vec3f direction; ///< unit, opposite to the propagation
  Vec3f normal;    ///< geometric, unit, on the side from which the photon arrived
  Rgb power;       ///< flux [W]
  LightState state;
  bool caustic = false; ///< true: from a caustic map, if there is one
};

/** Box of a photon map's tree. */
struct PhotonBox {
  Bounds3f box;         ///< tight bounds of its photons [scene units], relative to Scene::origin()
  int level = 0;        ///< number of splits above it
  uint64_t photons = 0; ///< number in the box
  bool caustic = false; ///< see StoredPhoton
};

/** Patch of a radiosity solution, a triangle. */
struct RadiosityPatch {
  std::array<Vec3f, 3> corners; ///< on the surface [scene units], relative to Scene::origin()
  Vec3f normal;                 ///< geometric, unit, at the centroid, on the outer side
  float area = 0;               ///< where alpha leaves it opaque [scene units²]
  std::array<Rgb, 2> received;  ///< irradiance without direct light, on the outer and the inner side [W/m²]
  std::array<Rgb, 2> albedo;    ///< at the centroid, on both sides
  /** Radiosity without the reflection of direct light, on the outer or the inner side [W/m²]. */
  Rgb radiosity(size_t side) const { return albedo[side] * received[side]; }
};

/** Estimator of the radiance along camera rays, with a forward pass for what several rays share. */
class Integrator {
 public:
  virtual ~Integrator() = default;
  /** Called once, before the first pass; passes() and the functions `supports...` may be called earlier.
   * Returns the work that it took. Throws Error when it cannot render the scene. */
  virtual TransportCounts prepare(const Scene&, const PathClasses&) { return {}; }
  /** Schedule of forward() for this number of samples of each pixel; 0: unlimited. */
  virtual Passes passes(int /*samplesPerPixel*/) const { return Passes::oneMap(); }
  /** Whether forward() splats light paths to pixels through a Splatter. */
  virtual bool splats() const { return false; }
  /** Number of photons that forward() emits in each pass; 0: none, or not stated. */
  virtual uint64_t photonsEmitted(const Scene&) const { return 0; }
  /** Whether the camera rays of a pass have the time of its photons, so that no estimate mixes times. */
  virtual bool passHasOneTime() const { return false; }
  /** Runs the forward pass, never at the same time as backward(). Its result must depend only on the pass and
   * on the first one, which is always run before. */
  virtual ForwardStatistics forward(const Scene&, const PathClasses&, const Pass&, const ForwardControl&) {
    return {};
  }
  /** Adds an estimate of the radiance along a camera ray to `out`, without CameraRay::weight. Several threads
   * call it at the same time, each with a sampler and an `out` of its own. */
  virtual void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                        PathRadiance& out) const = 0;
  /** Estimates several camera paths with the same classes. Each result is identical to the result of
   * backward(). */
  virtual void backwardBatch(const Scene& scene, std::span<CameraPath> paths) const {
    for (CameraPath& p : paths) backward(scene, p.ray, p.sampler, *p.out);
  }
  /** Calls visit(photon) for each surface photon in the map of the latest forward(). */
  virtual void visitPhotons(const std::function<void(const StoredPhoton&)>& /*visit*/) const {}
  /** Plural name of the points that visitPhotons() visits. */
  virtual std::string photonName() const { return "photons"; }
  /** Expression of the paths L…DE whose light these points carry to the last surface D. Light straight
   * through panes may be missing, and media may add paths. */
  virtual std::string photonPaths() const { return "all"; }
  /** Calls visit(box) for the boxes of the photon maps' trees with less than `levels` splits above them, each
   * box before its parts. */
  virtual void visitPhotonBoxes(int /*levels*/,
                                const std::function<void(const PhotonBox&)>& /*visit*/) const {}
  /** Calls visit(patch) for the patches of the latest forward(), if the integrator divides surfaces. */
  virtual void visitPatches(const std::function<void(const RadiosityPatch&)>& /*visit*/) const {}
  /** Index of the patch at a hit, in the order of visitPatches(); none where the surface is not divided. */
  virtual std::optional<uint32_t> patchAt(const Hit&) const { return {}; }
  /** Samples a point of a patch where alpha leaves it opaque, uniform in the surface's coordinates. The patch
   * must exist. */
  virtual SurfacePoint samplePatch(uint32_t /*patch*/, Sampler&) const { return {}; }
  /** Whether forward() learns directions of incident light for camera paths. */
  virtual bool learnsDirections() const { return false; }
  /** Directions learned by the latest forward() for a surface point that is seen from unit `wi`. */
  virtual LearnedDirections directionsAt(const SurfacePoint&, const Vec3f& /*wi*/) const { return {}; }
  /** Whether the integrator renders the media of the scene. */
  virtual bool supportsMedia(const Scene&) const { return false; }
  /** Whether it measures the lengths of all paths in the scene, for transient renders. */
  virtual bool supportsTransient(const Scene&) const { return false; }
  /** Whether it renders FIBRE materials, whose BSDF is not reciprocal. */
  virtual bool supportsFibres() const { return true; }
  /** Estimators and the domain of each; where the scene determines choices(), the domains chosen in the first
   * pass. */
  virtual std::vector<EstimatorDomain> domains() const = 0;
  /** Choices that the first pass makes by the scene, in words; empty: none. */
  virtual std::string choices() const { return {}; }
  /** Expression of the paths that the method computes, if it omits others by nature; empty: all paths at
   * surfaces. */
  virtual std::string claims() const { return {}; }
  /** Assumptions about these paths that the method makes even where the scene violates them, in words; empty:
   * none. */
  virtual std::string suppositions() const { return {}; }
  /** Whether it adds light that comes from no lamp of the scene, such as an ambient term. */
  virtual bool addsLightOfNoLamp() const { return false; }
};

/** Features of the scene that the integrator does not render, in words; empty: none. */
inline std::string unsupportedPart(const Integrator& integrator, const Scene& scene) {
  if (scene.hasMedia() && !integrator.supportsMedia(scene)) return "media such as those of the scene";
  if ((scene.contents().lobes & FIBRE) && !integrator.supportsFibres()) return "hair";
  return {};
}

/** Memory to build a map of this many stored photons [bytes]: the photons in the order of emission, and in
 * the order of the tree. */
double photonMapBytes(double stored);

} // namespace recurse
