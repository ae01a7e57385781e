/** @file
 * Plain path tracer as an integrator (integrators/path/plainPath.cpp): the estimators of `path`, one path at
 * a time. Lights are sampled by power.
 */
#include "integrators/path/plainPath.h"
#include "recurse/model/scene/plugIns.h"
#include "transport/integrator/maxDepthParameter.h"

namespace recurse {

namespace {

class SimplePath final : public Integrator {
 public:
  explicit SimplePath(int maxDepth) : maxDepth(maxDepth) {}

  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    tracePlainPath(scene, ray, byPower, {maxDepth}, sampler, out);
  }

  std::vector<EstimatorDomain> domains() const override { return plainPathDomains(1); }
  bool supportsMedia(const Scene&) const override { return true; }

 private:
  int maxDepth;
  LightSampler byPower; ///< unlearned: chooses by power
};

} // namespace

void registerSimplePath(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "simplepath",
        .summary = "A path tracer with short source code, for teaching: the same picture as path, slower.",
        .parameters = {maxDepthParameter(),
                       booleanParameter("samplebsdf", "true",
                                        "BSDFs are always sampled; false only gives a warning"),
                       booleanParameter("samplelights", "true",
                                        "lights are always sampled; false only gives a warning")},
        .examples = {""}},
       [](const Parameters& p, const NoContext&) {
         for (const char* name : {"samplebsdf", "samplelights"})
           if (!p.boolean(name))
             p.warn(name,
                    std::string("\"") + name + "\" false has no effect: BSDFs and lights are both sampled");
         return std::make_unique<SimplePath>(p.integer("maxdepth"));
       }});
}

} // namespace recurse
