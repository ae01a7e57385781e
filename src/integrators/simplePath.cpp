/** @file
 * A path tracer to be read: what `path` does, one path after the other (Kajiya 1986, "The Rendering
 * Equation", with the shadow rays and weights of Veach 1997, chapters 8 and 9). Lights are sampled by power.
 */
#include "recurse/model/plugIns.h"
#include "recurse/transport/directLight.h"
#include "recurse/transport/walker.h"

namespace recurse {

namespace {

class SimplePath final : public Integrator {
 public:
  explicit SimplePath(int maxDepth) : maxDepth(maxDepth) {}

  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    const PathClasses& classes = out.pathClasses();
    Walker<CameraState> walker(scene, classes, out.counts, maxDepth);
    CameraSubpath path = startCameraSubpath(scene, classes, ray, out.counts);
    CameraVertex vertex;
    BsdfRay last;
    const auto addEmission = [&](const Hit* hit) {
      const Vec3f& direction = path.ray.direction;
      const Rgb emitted = hit ? emittedRadiance(scene, byPower, *hit, direction, last, SHADOW_RAYS)
                              : environmentRadiance(scene, byPower, direction, last, SHADOW_RAYS);
      out.add(classes.lightStart(), path.state, path.throughput * emitted);
    };
    while (walker.next(path, vertex, addEmission)) {
      if (vertex.isConnectable())
        addSampledLight(scene, byPower, {vertex.point().position}, *vertex.scattering, vertex.hit,
                        path.nesting, vertex.wi, vertex.throughput, vertex.afterD, SHADOW_RAYS, ALL_LOBES,
                        panesLeft(maxDepth, vertex.depth), sampler, out);
      const std::optional<Scatter> s = walker.scatter(path, vertex, sampler);
      if (!s) break;
      if (!passesPane(scene, *vertex.scattering, *s))
        last = {{path.from}, static_cast<float>(path.pdf), !path.delta};
    }
  }

  std::vector<EstimatorDomain> domains() const override {
    return {{"emission", "LS*E", "none: met by eye rays through mirrors and glass", "", true},
            {"emission after scattering", "LS+D(S|D)*E", "none: met by the rays that go on",
             "direct light through panes", true},
            {"shadow rays through panes", "LS+D(S|D)*E", "none: the same, straight through thin panes",
             "direct light through panes", false, true},
            {"shadow rays", "LD(S|D)*E", "one for each diffuse vertex", "direct light"},
            {"BSDF rays", "LD(S|D)*E", "none: the rays that go on", "direct light", true}};
  }

 private:
  static constexpr int SHADOW_RAYS = 1; ///< at each vertex
  int maxDepth;
  LightSampler byPower; ///< has learned nothing
};

} // namespace

void registerSimplePath(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "simplepath",
        .summary = "A path tracer to be read: the same picture as path, slower.",
        .parameters = {integerParameter("maxdepth", "-1", "most scattering events of a path; -1: no limit")
                           .range(-1, 1e9),
                       ignoredParameter(ParameterType::BOOLEAN, "samplebsdf", "it always does"),
                       ignoredParameter(ParameterType::BOOLEAN, "samplelights", "it always does")},
        .examples = {""}},
       [](const Parameters& p, const NoContext&) {
         return std::make_unique<SimplePath>(p.integer("maxdepth"));
       }});
}

} // namespace recurse
