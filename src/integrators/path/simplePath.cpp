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
  explicit SimplePath(const PlainPathSettings& settings) : settings(settings) {}

  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    tracePlainPath(scene, ray, byPower, settings, sampler, out);
  }

  std::vector<EstimatorDomain> domains() const override { return plainPathDomains(settings.lightSamples); }
  bool supportsMedia(const Scene&) const override { return true; }
  bool supportsTransient(const Scene& scene) const override { return !scene.hasEmissiveMedia(); }

 private:
  PlainPathSettings settings;
  LightSampler byPower; ///< unlearned: chooses by power
};

} // namespace

void registerSimplePath(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "simplepath",
        .summary = "A path tracer with short source code, for teaching: the same picture as path, slower.",
        .parameters =
            {maxDepthParameter(),
             booleanParameter("samplebsdf", "true",
                              "directions by the BSDF; false: uniform over the hemisphere, except at mirrors "
                              "and surfaces that transmit light"),
             booleanParameter("samplelights", "true",
                              "shadow rays to the lights; false: rays find lights by chance, and no point, "
                              "spot or distant lights")},
        .examples = {"", "\"bool samplelights\" false \"bool samplebsdf\" false"}},
       [](const Parameters& p, const NoContext&) {
         PlainPathSettings settings;
         settings.maxDepth = p.integer("maxdepth");
         settings.lightSamples = p.boolean("samplelights") ? 1 : 0;
         settings.sampleBsdf = p.boolean("samplebsdf");
         return std::make_unique<SimplePath>(settings);
       }});
}

} // namespace recurse
