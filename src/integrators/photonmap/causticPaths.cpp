/** @file
 * Path tracing with photons of caustics alone.
 */
#include <utility>

#include "integrators/path/pathTracing.h"
#include "integrators/photonmap/photonMapping.h"
#include "transport/density/gather.h"
#include "transport/density/storedPhotons.h"

namespace recurse {

namespace {

class CausticPaths final : public PhotonMapper, private CausticPhotons {
 public:
  CausticPaths(const PhotonMappingSettings& s, const LightSampler* learnedLights, const PhotonPass* teacher)
      : settings(s), photons(onlyCaustics(s)), lights(learnedLights ? *learnedLights : ownLights),
        pathTracer(makePathTracing({s.maxDepth, s.lightSamples}, this, &lights)) {
    if (teacher) photons.learnFrom(*teacher);
  }

  Passes passes(int /*samplesPerPixel*/) const override { return settings.passes; }
  uint64_t photonsEmitted(const Scene& scene) const override {
    return photons.photonCount(scene, settings.passes.schedule() != PassSchedule::ONE_MAP);
  }
  bool passHasOneTime() const override { return true; }
  bool supportsMedia(const Scene& scene) const override { return !hasMediaWithoutEnd(scene); }
  bool supportsTransient(const Scene& scene) const override { return !scene.hasEmissiveMedia(); }

  void prepare(const Scene& scene, const PathClasses& classes) override {
    if (&lights == &ownLights && settings.without != Mechanism::LIGHT_LEARNING)
      learned = ownLights.learn(scene, settings.without != Mechanism::SHADOW_OPENINGS);
    pathTracer->prepare(scene, classes);
  }
  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override {
    ForwardStatistics statistics = photons.run(scene, classes, pass, control, lights);
    statistics.counts.add(std::exchange(learned, {}));
    return statistics;
  }
  ForwardStatistics withPass(const Pass& other, const Scene& scene, const PathClasses& classes,
                             const ForwardControl& control, const std::function<void()>& use) override {
    return photons.with(other, scene, classes, control, lights, use);
  }
  const PhotonPass& photonPass() const override { return photons; }
  void visitPhotons(const std::function<void(const StoredPhoton&)>& visit) const override {
    visitMap(photons.caustics().map, true, visit);
  }
  std::string photonPaths() const override { return "LS+DE"; }
  void visitPhotonBoxes(int levels, const std::function<void(const PhotonBox&)>& visit) const override {
    visitMapBoxes(photons.caustics().map, true, levels, visit);
  }

  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    pathTracer->backward(scene, ray, sampler, out);
  }
  void backwardBatch(const Scene& scene, std::span<CameraPath> paths) const override {
    pathTracer->backwardBatch(scene, paths);
  }
  std::vector<EstimatorDomain> domains() const override {
    std::vector<EstimatorDomain> all = pathTracer->domains();
    all.push_back({"caustic photons", "LS+D(S|D|V)*E",
                   "one density estimate for each non-delta surface of a path",
                   "direct light through panes"});
    return all;
  }

 private:
  static PhotonPassSettings onlyCaustics(PhotonPassSettings settings) {
    settings.causticsOnly = true;
    settings.directLight = false;
    return settings;
  }

  float add(const Scene& scene, const SurfacePoint& point, const Vec3f& wi, const ScatteringPoint& scattering,
            const Rgb& throughput, CameraState camera, float width, const OpticalPath& optical,
            const Sampler& sampler, PathRadiance& out) const override {
    constexpr uint32_t FORK = 0x4341; // distinct from other forks of the same sampler
    if (!scattering.keepsPhotons()) return 0;
    const PhotonQuery query = photons.query(photons.caustics(), point, wi, scattering.lobes());
    if (!isTaken(query.settings, sampler)) return mergingUnseen(query.settings, width * photons.scale());
    BoundaryCorrection boundary{scene, sampler.fork(FORK), query.cached.known, query.cached.away};
    if (out.recorder) out.recorder->beginEstimate(out.recorder->source.vertex, true);
    const GatherResult result =
        gather(photons.caustics().map, query.settings, scattering, point, wi, width * photons.scale(),
               throughput, camera, out, photons.hasEdges() ? &boundary : nullptr, optical);
    if (out.recorder) out.recorder->endEstimate(result.radius, result.found);
    out.counts.causticRadii.add(result.radius, width);
    return result.merging;
  }
  float rayWeight(const Scene& scene, const MergeRatio& merge, const Hit& hit,
                  const Vec3f& direction) const override {
    return photons.rayWeight(scene, merge, hit, direction);
  }
  float rayWeight(const Scene& scene, const MergeRatio& merge, size_t environment,
                  const Ray& ray) const override {
    return photons.rayWeight(scene, merge, environment, ray);
  }

  PhotonMappingSettings settings;
  PhotonPass photons;
  LightSampler ownLights;
  const LightSampler& lights;
  TransportCounts learned; ///< counts of light learning, until forward() returns them
  std::unique_ptr<Integrator> pathTracer;
};

} // namespace

std::unique_ptr<PhotonMapper> makeCausticPaths(const PhotonMappingSettings& settings,
                                               const LightSampler* lights, const PhotonPass* teacher) {
  return std::make_unique<CausticPaths>(settings, lights, teacher);
}

} // namespace recurse
