/** @file
 * Recursive ray tracing (Whitted 1980, "An Improved Illumination Model for Shaded Display"): all delta
 * directions of mirrors and glass are followed; other surfaces have direct light only.
 */
#include "recurse/model/scene/plugIns.h"
#include "transport/direct/localShading.h"
#include "transport/learning/lightLearning.h"
#include "transport/paths/recordedCamera.h"
#include "transport/paths/walker.h"

namespace recurse {

namespace {

class Whitted final : public Integrator {
 public:
  Whitted(int maxDepth, float minWeight)
      : maxDepth(maxDepth < 0 ? LOSSLESS_ROULETTE_DEPTH : maxDepth), minWeight(minWeight) {}

  TransportCounts prepare(const Scene& scene, const PathClasses&) override {
    return learnLights(scene, lights);
  }

  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    const PathClasses& classes = out.pathClasses();
    CameraWalker walker(scene, classes, out.counts, maxDepth);
    // Stack of pending branches: a recursion could be as deep as facing mirrors make it.
    std::vector<Branch> branches = {
        {startCameraSubpath(scene, classes, ray, out.counts), RecordedCameraPath(out.recorder)}};
    CameraVertex vertex;
    while (!branches.empty() && !out.abandoned()) {
      auto [path, record] = branches.back();
      branches.pop_back();
      const auto addEmission = [&, &path = path, &record = record](const Hit* hit) {
        addSeenEmission(scene, lights, path, hit, record.step(), out);
      };
      if (!walker.next(path, vertex, sampler, addEmission)) continue;
      record.arrive(vertex);
      addDirectLight(scene, lights, vertex, path.nesting, sampler, out);
      branch(walker, {path, record}, vertex, branches, out);
    }
  }

  std::string claims() const override { return "LD?S*E"; }
  std::vector<EstimatorDomain> domains() const override {
    return {{"emission", "LS*E", "none: found by rays through mirrors and glass", "", true},
            {"shadow rays", "LDS*E", "one for each surface of a ray", "direct light"},
            {"BSDF rays", "LDS*E", "one for each surface of a ray", "direct light", true}};
  }

 private:
  struct Branch {
    CameraSubpath path;
    RecordedCameraPath record;
  };

  /** Branches into all delta directions of the vertex. Counts the throughput of those below the threshold. */
  void branch(const CameraWalker& walker, const Branch& from, const CameraVertex& vertex,
              std::vector<Branch>& branches, PathRadiance& out) const {
    if (!(vertex.allowed & DELTA_LOBES)) return;
    std::array<Scatter, DeltaScatters::MAX_COUNT> all;
    const int count = vertex.scattering->deltaScatters(vertex.wi, Transport::RADIANCE, all);
    for (int i = 0; i < count; ++i) {
      Branch next = from;
      const Scatter& step = all[static_cast<size_t>(i)];
      walker.follow(next.path, vertex, step);
      const Rgb& throughput = next.path.throughput;
      const float weight = maxComponent(throughput) * next.path.etaScale;
      if (weight >= minWeight && weight > 0) {
        next.record.leave(vertex, step, throughput);
        branches.push_back(next);
      } else {
        out.counts.truncatedThroughput += double(maxComponent(throughput));
      }
    }
  }

  int maxDepth;
  float minWeight;
  LightSampler lights;
};

} // namespace

void registerWhitted(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "whitted",
        .summary = "Whitted's recursive ray tracing: direct light, mirrors and glass. No indirect light of "
                   "diffuse surfaces, no caustics.",
        .parameters = {integerParameter("maxdepth", "100",
                                        "maximum number of scattering events of a path; -1: 512")
                           .range(-1, 1e6),
                       realParameter("minweight", "0.001",
                                     "rays with a smaller weight (their factor in the pixel) are not traced; "
                                     "the summary reports the weight that is lost")
                           .range(0, 1)},
        .examples = {"", "\"integer maxdepth\" 5 \"float minweight\" .01"}},
       [](const Parameters& p, const NoContext&) {
         return std::make_unique<Whitted>(p.integer("maxdepth"), static_cast<float>(p.real("minweight")));
       }});
}

} // namespace recurse
