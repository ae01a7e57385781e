/** @file
 * Path tracing with photons of caustics alone.
 */
#include "integrators/path/pathTracing.h"
#include "integrators/photonmap/photonMapping.h"
#include "transport/density/gather.h"
#include "transport/density/storedPhotons.h"

namespace recurse {

namespace {

class CausticPaths final : public PhotonMapper, private CausticPhotons {
 public:
  CausticPaths(const PhotonMappingSettings& s, const LightSampler* learnedLights, const PhotonPass* teacher)
      : PhotonMapper(onlyCaustics(s), learnedLights),
        pathTracer(makePathTracing({s.maxDepth, s.lightSamples}, this, &lights)) {
    if (teacher) photons.learnFrom(*teacher);
  }

  void prepare(const Scene& scene, const PathClasses& classes) override {
    PhotonMapper::prepare(scene, classes);
    pathTracer->prepare(scene, classes);
  }
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
  static PhotonMappingSettings onlyCaustics(PhotonMappingSettings settings) {
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
    BoundaryCorrection boundary{scene, sampler.fork(FORK), query.cached.known, query.cached.away};
    if (out.recorder) out.recorder->beginEstimate(out.recorder->source.vertex, true);
    const GatherResult result =
        gather(photons.caustics().map, query.settings, scattering, point, wi, width * photons.scale(),
               throughput, camera, out, photons.hasEdges() ? &boundary : nullptr, &sampler, optical);
    if (out.recorder) out.recorder->endEstimate(result.radius, result.found);
    out.counts.causticRadii.add(result.radius, width);
    return result.mergeDensity;
  }
  float rayWeight(const Scene& scene, const MergeRatio& merge, const Hit& hit,
                  const Ray& ray) const override {
    return photons.rayWeight(scene, merge, hit, ray.direction);
  }
  float rayWeight(const Scene& scene, const MergeRatio& merge, size_t environment,
                  const Ray& ray) const override {
    return photons.rayWeight(scene, merge, environment, ray);
  }

  std::unique_ptr<Integrator> pathTracer;
};

} // namespace

std::unique_ptr<PhotonMapper> makeCausticPaths(const PhotonMappingSettings& settings,
                                               const LightSampler* lights, const PhotonPass* teacher) {
  return std::make_unique<CausticPaths>(settings, lights, teacher);
}

} // namespace recurse
