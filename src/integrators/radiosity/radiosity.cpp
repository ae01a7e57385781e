/** @file
 * Progressive refinement radiosity (Cohen, Chen, Wallace, Greenberg 1988) with form factors by rays: diffuse
 * surfaces are divided into patches, the patch with the most unshot power shoots next, and received
 * irradiance is interpolated between corners. Shadow rays sample direct light instead.
 */
#include <algorithm>
#include <queue>
#include <utility>

#include "integrators/radiosity/patches.h"
#include "recurse/core/io/text.h"
#include "recurse/core/sampling/sampling.h"
#include "recurse/core/threads/processorTime.h"
#include "recurse/model/scene/plugIns.h"
#include "transport/direct/localShading.h"
#include "transport/emission/emissionSampler.h"
#include "transport/forward/photonGuidance.h"
#include "transport/learning/lightLearning.h"
#include "transport/paths/recordedCamera.h"
#include "transport/paths/walker.h"

namespace recurse {

namespace {

constexpr uint64_t LIGHT_RAYS = 0x5241444c49474854ull, PATCH_RAYS = 0x5241445041544348ull;
/** Fraction of the initial unshot power at which the solution has converged. */
constexpr double CONVERGED = 1e-3;
/** Minimum number of rays in a shot: fewer would cause bright single patches. */
constexpr int MIN_RAYS = 32;

class Radiosity final : public Integrator {
 public:
  Radiosity(int rays, float patchSize) : rays(rays), patchSize(patchSize) {}

  TransportCounts prepare(const Scene& scene, const PathClasses& classes) override {
    patches.dice(scene, patchSize);
    states = classes.lightStateCount();
    return learnLights(scene, lights);
  }

  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override {
    ForwardStatistics statistics;
    const auto start = std::chrono::steady_clock::now();
    statistics.notes.push_back(formatted("radiosity: %zu patches with edges up to about %.3g on %zu faces",
                                         patches.count(), double(patches.longestEdge()),
                                         patches.faceCount()));
    if (patches.ignoredShapes() > 0)
      statistics.warnings.push_back(formatted("radiosity: %zu of the scene's shapes reflect no indirect "
                                              "light: only shapes at rest with one diffuse "
                                              "material, which can be divided into patches, reflect it",
                                              patches.ignoredShapes()));
    {
      const ProcessorTimer timer(statistics.learningSeconds);
      guide = learnEmission(scene, classes, pass.seed, -1, control, statistics.counts);
    }
    solve(scene, classes, pass, control, statistics);
    reconstruct();
    statistics.photonsEmitted = static_cast<uint64_t>(rays);
    statistics.shootSeconds = secondsSince(start);
    return statistics;
  }

  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    const PathClasses& classes = out.pathClasses();
    CameraWalker walker(scene, classes, out.counts, 1);
    CameraSubpath path = startCameraSubpath(scene, classes, ray, out.counts);
    CameraVertex vertex;
    const auto addEmission = [&](const Hit* hit) {
      addSeenEmission(scene, lights, path, hit, CAMERA_STEP, out);
    };
    if (!walker.next(path, vertex, sampler, addEmission)) return;
    RecordedCameraPath(out.recorder).arrive(vertex);
    addDirectLight(scene, lights, vertex, path.nesting, sampler, out);
    const auto patchPoint = vertex.isConnectable() ? find(vertex.hit, *vertex.scattering) : std::nullopt;
    if (!patchPoint) return;
    if (PathRecorder* recorder = out.recorder)
      recorder->source = {.technique = PathTechnique::PATCHES, .vertex = recorder->source.vertex};
    const Vec3f normal = vertex.point().normalTowards(vertex.wi);
    const Rgb f = vertex.scattering->value(vertex.wi, normal);
    const size_t side = sideOf(vertex.wi, vertex.point());
    for (size_t s = 0; s < states; ++s) {
      Rgb e = BLACK;
      for (size_t k = 0; k < 3; ++k)
        e += cornerIrradiance[at(patchPoint->corners[k], side, s)] * patchPoint->weights[k];
      if (!isBlack(e)) out.add(LightState(static_cast<uint8_t>(s)), vertex.afterD, f * e);
    }
  }

  void visitPatches(const std::function<void(const RadiosityPatch&)>& visit) const override {
    if (received.empty()) return; // forward() has not run
    for (uint32_t p = 0; p < patches.count(); ++p) {
      RadiosityPatch out = patches.describe(p);
      for (size_t side = 0; side < 2; ++side) {
        out.received[side] = BLACK;
        for (size_t s = 0; s < states; ++s) out.received[side] += received[at(p, side, s)];
      }
      visit(out);
    }
  }
  std::optional<uint32_t> patchAt(const Hit& hit) const override {
    const std::optional<PatchPoint> found = patches.find(hit);
    return found ? std::optional(found->patch) : std::nullopt;
  }
  SurfacePoint samplePatch(uint32_t patch, Sampler& sampler) const override {
    return patches.sample(patch, sampler);
  }

  std::string claims() const override { return "LD*E"; }
  std::string suppositions() const override {
    return "that indirect light is constant or changes linearly over a patch, and only diffuse surfaces "
           "reflect it";
  }
  std::vector<EstimatorDomain> domains() const override {
    return {{"emission", "LE", "none: found by camera rays", "", true},
            {"shadow rays", "LDE", "one for each camera ray", "direct light"},
            {"BSDF rays", "LDE", "one for each camera ray", "direct light", true},
            {"patches", "LDD+E", "none: interpolated from the patches", ""}};
  }

 private:
  /** Index of the side and light state of a patch or corner in the arrays. */
  size_t at(size_t item, size_t side, size_t state) const { return (2 * item + side) * states + state; }
  static size_t sideOf(const Vec3f& wi, const SurfacePoint& point) {
    return glm::dot(wi, point.geometricNormal) > 0 ? 0 : 1;
  }
  std::optional<PatchPoint> find(const Hit& hit, const ScatteringPoint& scattering) const {
    return scattering.lobes() & LAMBERTIAN ? patches.find(hit) : std::nullopt;
  }

  // --------------------------------------------------------------------------------------------- shooting

  /** Power in each light state [W]. */
  using Power = std::vector<Rgb>;

  void solve(const Scene& scene, const PathClasses& classes, const Pass& pass, const ForwardControl& control,
             ForwardStatistics& statistics) {
    const size_t sides = 2 * patches.count();
    received.assign(sides * states, BLACK);
    unshot.assign(sides * states, BLACK);
    queue = {};
    queued.assign(sides, 0);
    Power power(states, BLACK);
    for (int i = 0; i < rays && !control.stopped() && scene.lights().size() > 0; ++i) {
      Sampler sampler(hashCombine(pass.seed, pass.index), LIGHT_RAYS, static_cast<uint32_t>(i));
      const auto start = startLightSubpath(scene, classes, pass.time, sampler, statistics.counts, &guide);
      if (!start) continue;
      power[start->path.state.byte] = start->path.throughput / static_cast<float>(rays);
      send(scene, classes, start->path.ray, start->path.nesting, power, true, statistics.counts);
      power[start->path.state.byte] = BLACK;
    }
    double total = 0;
    for (size_t i = 0; i < sides; ++i) total += powerOf(i);
    double left = total;
    uint64_t shot = 0;
    while (!queue.empty() && left > CONVERGED * total && !control.stopped()) {
      const auto [value, index] = queue.top();
      queue.pop();
      const size_t i = ~index;
      const double now = powerOf(i);
      queued[i] = 0;
      if (now != value) { // has received more since
        enqueue(i, now);
        continue;
      }
      left += shoot(scene, classes, pass, i, now / total, shot, power, statistics.counts) - now;
      control.progress(
          std::clamp(std::log(std::max(left / total, CONVERGED)) / std::log(CONVERGED), 0.0, 1.0));
    }
    statistics.notes.push_back(
        formatted("radiosity: %.3g million rays for form factors; %.3g %% of the reflected light "
                  "was not distributed",
                  double(shot) / 1e6, total > 0 ? 100 * left / total : 0));
  }

  double powerOf(size_t patchSide) const {
    double sum = 0;
    for (size_t s = 0; s < states; ++s) sum += double(luminance(unshot[patchSide * states + s]));
    return sum;
  }
  /** Queues a side of a patch; ties go to the lower index. */
  void enqueue(size_t patchSide, double power) {
    if (!(power > 0)) return;
    queued[patchSide] = power;
    queue.push({power, ~patchSide});
  }

  /** Shoots all unshot power of a patch. Returns the increase of unshot power that this causes. */
  double shoot(const Scene& scene, const PathClasses& classes, const Pass& pass, size_t patchSide,
               double fraction, uint64_t& shot, Power& power, TransportCounts& counts) {
    const int count = std::max(MIN_RAYS, static_cast<int>(std::ceil(fraction * rays)));
    for (size_t s = 0; s < states; ++s) {
      power[s] = unshot[patchSide * states + s] / static_cast<float>(count);
      unshot[patchSide * states + s] = BLACK;
    }
    double gained = 0;
    for (int i = 0; i < count; ++i, ++shot) {
      Sampler sampler(hashCombine(pass.seed, pass.index), PATCH_RAYS + patchSide,
                      static_cast<uint32_t>(shot));
      const SurfacePoint from = patches.sample(static_cast<uint32_t>(patchSide / 2), sampler);
      const Vec3f normal = from.geometricNormal * (patchSide % 2 == 0 ? 1.0f : -1.0f);
      const Ray ray = spawn(from, Frame(normal).toWorld(cosineHemisphere(sampler.next2D())));
      gained += send(scene, classes, ray, {}, power, false, counts);
    }
    std::fill(power.begin(), power.end(), BLACK);
    return gained;
  }

  /** Sends power along a ray to its first surface. Direct light is reflected but not received, since shadow
   * rays sample it. Returns the increase of unshot power. */
  double send(const Scene& scene, const PathClasses& classes, Ray ray, Nesting nesting, const Power& power,
              bool direct, TransportCounts& counts) {
    Hit hit;
    for (;;) {
      if (!intersect(scene, ray, hit, counts)) return 0;
      arena.reset();
      const Bsdf* bsdf = bsdfAt(scene, hit, ray.direction, Footprint(), nesting, arena);
      if (!bsdf) {
        ray = rayBehind(ray, hit);
        continue;
      }
      const ScatteringPoint scattering(*bsdf, hit.point);
      const auto patchPoint = find(hit, scattering);
      if (!patchPoint) return 0;
      const Vec3f wi = -ray.direction;
      const uint32_t patch = patchPoint->patch;
      const size_t side = sideOf(wi, hit.point);
      const Rgb albedo = scattering.value(wi, hit.point.normalTowards(wi)) * PI;
      const float perArea = 1 / patches.area(patch);
      const SurfaceKind kind = surfaceKind(classes, hit);
      const double before = powerOf(2 * patch + side);
      for (size_t s = 0; s < states; ++s) {
        if (isBlack(power[s])) continue;
        if (!direct) received[this->at(patch, side, s)] += power[s] * perArea;
        const LightState after = classes.step(LightState(static_cast<uint8_t>(s)), PathEvent::D, kind);
        if (!classes.dead(after)) unshot[this->at(patch, side, after.byte)] += power[s] * albedo;
      }
      const double after = powerOf(2 * patch + side);
      // Requeues only when the power has doubled, so that the queue stays short.
      if (after > 2 * queued[2 * patch + side]) enqueue(2 * patch + side, after);
      return after - before;
    }
  }

  /** Computes the irradiance at the corners: area-weighted means over the patches around them. */
  void reconstruct() {
    cornerIrradiance.assign(2 * patches.cornerCount() * states, BLACK);
    std::vector<float> area(patches.cornerCount(), 0);
    for (uint32_t patch = 0; patch < patches.count(); ++patch) {
      const float a = patches.area(patch);
      for (const uint32_t corner : patches.corners(patch)) {
        area[corner] += a;
        for (size_t k = 0; k < 2 * states; ++k)
          cornerIrradiance[2 * states * corner + k] += received[2 * states * patch + k] * a;
      }
    }
    for (size_t c = 0; c < area.size(); ++c)
      if (area[c] > 0)
        for (size_t k = 0; k < 2 * states; ++k) cornerIrradiance[2 * states * c + k] /= area[c];
  }

  int rays;
  float patchSize;
  LightSampler lights;
  EmissionMixture guide; ///< emission density of the rays from the lights
  Patches patches;
  size_t states = 1;                 ///< number of states of a light path
  std::vector<Rgb> received;         ///< irradiance without direct light [W/area], by patch, side and state
  std::vector<Rgb> unshot;           ///< unshot reflected power [W], by patch, side and state
  std::vector<Rgb> cornerIrradiance; ///< irradiance at corners, by corner, side and state
  std::priority_queue<std::pair<double, size_t>>
      queue;                  ///< unshot power, and the complement of the index of patch and side
  std::vector<double> queued; ///< power with which each side is in the queue, by patch and side
  BsdfArena arena;
};

} // namespace

void registerRadiosity(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "radiosity",
        .summary = "Radiosity: indirect light between patches of diffuse surfaces, interpolated between "
                   "patches. Other surfaces get direct light only.",
        .parameters = {integerParameter("rays", "1000000",
                                        "number of rays that sample the form factors, approximately")
                           .range(1, 1e9),
                       realParameter("patchsize", "",
                                     "longest edge of a patch [scene units]; by default chosen for about "
                                     "10000 patches, or more if faces are thin")
                           .positive()},
        .examples = {"", "\"integer rays\" 20000 \"float patchsize\" .5"}},
       [](const Parameters& p, const NoContext&) {
         return std::make_unique<Radiosity>(
             p.integer("rays"), p.hasValue("patchsize") ? static_cast<float>(p.real("patchsize")) : 0);
       }});
}

} // namespace recurse
