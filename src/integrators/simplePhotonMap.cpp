/** @file
 * Plain photon mapper for study (Jensen 2001, "Realistic Image Synthesis Using Photon Mapping", chapters 5 to
 * 8): one map of all light, one photon and one ray at a time.
 */
#include <chrono>

#include "recurse/core/threads/processorTime.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/transport/integrator/lightPathRecorder.h"
#include "transport/density/gather.h"
#include "transport/density/storedPhotons.h"
#include "transport/direct/localShading.h"
#include "transport/emission/emissionSampler.h"
#include "transport/integrator/maxDepthParameter.h"
#include "transport/paths/recordedCamera.h"
#include "transport/paths/recordedWalk.h"
#include "transport/paths/walker.h"

namespace recurse {

namespace {

class SimplePhotonMap final : public Integrator {
 public:
  SimplePhotonMap(uint64_t photons, const GatherSettings& search, int maxDepth)
      : photons(photons), search(search), maxDepth(maxDepth) {}

  TransportCounts prepare(const Scene& scene, const PathClasses&) override {
    if (!(search.radius > 0)) search.radius = MAX_RADIUS * scene.bounds().radius;
    return {};
  }
  bool passHasOneTime() const override { return true; }

  /** Traces photons from the lights, and builds their map. */
  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override {
    const auto start = std::chrono::steady_clock::now();
    ForwardStatistics statistics;
    std::vector<Photon> stored;
    std::vector<float> lengths;
    if (control.lightPaths) control.lightPaths->beginPass(photons);
    for (uint64_t i = 0; i < photons && scene.lights().size() > 0 && !control.stopped(); ++i) {
      RecordedWalk record(control.lightPaths, i, 1 / float(photons));
      followLightPath(scene, classes, pass, i, maxDepth, nullptr, statistics.counts, record,
                      [&](const LightSubpath& path, const LightVertex& vertex) {
                        if (vertex.isConnectable())
                          store(vertex, path.optical.length, stored,
                                classes.isTransient() ? &lengths : nullptr);
                      });
      if (i % 4096 == 0) control.progress(double(i) / double(photons));
    }
    statistics.shootSeconds = secondsSince(start);
    map.build(stored);
    if (classes.isTransient()) map.setLengths(lengths);
    statistics.photonsEmitted = photons;
    statistics.photonsStored = map.size();
    statistics.photonsRefused = map.refused();
    statistics.mapBytes = map.memoryBytes();
    return statistics;
  }

  /** Adds emission and the radiance estimate at the first non-delta vertices; follows mirrors and glass. */
  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    const PathClasses& classes = out.pathClasses();
    CameraWalker walker(scene, classes, out.counts, maxDepth);
    // Stack of pending rays: a recursion could be as deep as facing mirrors make it.
    std::vector<Branch> waiting = {
        {startCameraSubpath(scene, classes, ray, out.counts), RecordedCameraPath(out.recorder)}};
    while (!waiting.empty() && !out.abandoned()) {
      auto [path, record] = waiting.back();
      waiting.pop_back();
      CameraVertex vertex;
      const auto addEmission = [&, &path = path, &record = record](const Hit* hit) {
        addSeenEmission(scene, lights, path, hit, record.step(), out);
      };
      if (!walker.next(path, vertex, sampler, addEmission)) continue;
      record.arrive(vertex);
      if (vertex.isConnectable()) {
        if (out.recorder) out.recorder->beginEstimate(record.vertex(), false);
        const GatherResult result =
            gather(map, search, *vertex.scattering, vertex.point(), vertex.wi, path.width, vertex.throughput,
                   vertex.afterD, out, nullptr, nullptr, path.optical);
        if (out.recorder) out.recorder->endEstimate(result.radius, result.found);
        out.counts.otherRadii.add(result.radius, path.width);
      }
      if (!(vertex.allowed & DELTA_LOBES)) continue;
      const auto mirrored = vertex.scattering->specularReflectionBackwardScatter(vertex.wi);
      const auto refracted = vertex.scattering->specularRefractionBackwardScatter(vertex.wi, sampler);
      for (const std::optional<Scatter>& step : {mirrored, refracted}) {
        if (!step) continue;
        CameraSubpath next = path;
        walker.follow(next, vertex, *step);
        const float chance = maxComponent(next.throughput) * next.etaScale / BRANCH_WEIGHT;
        if (!russianRoulette(std::min(1.0f, chance), next.depth, sampler, next.throughput)) continue;
        waiting.push_back({next, record});
        waiting.back().record.leave(vertex, *step, next.throughput);
      }
    }
  }

  void visitPhotons(const std::function<void(const StoredPhoton&)>& visit) const override {
    visitMap(map, false, visit);
  }
  void visitPhotonBoxes(int levels, const std::function<void(const PhotonBox&)>& visit) const override {
    visitMapBoxes(map, false, levels, visit);
  }
  bool supportsFibres() const override { return false; }
  bool supportsTransient(const Scene&) const override { return true; }
  std::vector<EstimatorDomain> domains() const override {
    return {{"emission", "LS*E", "none: found by rays through mirrors and glass", "", true},
            {"photon map", "L(S|D)*DS*E", "one estimate at the first non-delta surface", ""}};
  }

 private:
  /** Ray that waits to be followed. */
  struct Branch {
    CameraSubpath path;
    RecordedCameraPath record;
  };

  static constexpr float MAX_RADIUS = 0.1f;    ///< over the scene's radius; bounds gathers in dark corners
  static constexpr float BRANCH_WEIGHT = 0.1f; ///< throughput below which roulette limits rays at glass

  void store(const LightVertex& vertex, float length, std::vector<Photon>& stored,
             std::vector<float>* lengths) const {
    const auto photon =
        photonAt(vertex.point(), vertex.wi, vertex.throughput / float(photons), vertex.state.byte);
    if (!photon) return;
    stored.push_back(*photon);
    if (lengths) lengths->push_back(length);
  }

  uint64_t photons; ///< number emitted in a pass
  GatherSettings search;
  int maxDepth;
  LightSampler lights; ///< unlearned; no shadow ray uses it
  PhotonMap map;
};

} // namespace

void registerSimplePhotonMap(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "simplephotonmap",
        .summary = "A photon mapper with short source code, for teaching: one photon map for all light, "
                   "direct light included.",
        .parameters =
            {integerParameter("photons", "200000", "photons emitted").range(1, 2e9),
             integerParameter("gatherphotons", "100", "number of nearest photons of a density estimate")
                 .range(1, 1e6),
             realParameter("radius", "",
                           "maximum radius of a density estimate [scene units]; by default a tenth of the "
                           "scene's radius")
                 .range(0, 1e17)
                 .positive(),
             maxDepthParameter("a camera path, and of a photon")},
        .examples = {"", "\"integer photons\" 20000 \"float radius\" .1"}},
       [](const Parameters& p, const NoContext&) {
         GatherSettings search;
         search.nearest = p.integer("gatherphotons");
         search.radius = p.hasValue("radius") ? static_cast<float>(p.real("radius")) : 0;
         return std::make_unique<SimplePhotonMap>(static_cast<uint64_t>(p.integer("photons")), search,
                                                  p.integer("maxdepth"));
       }});
}

} // namespace recurse
