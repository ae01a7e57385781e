/** @file
 * Ray casting (Appel 1968, "Some Techniques for Shading Machine Renderings of Solids"): direct light of the
 * visible surface, and a constant ambient term for all other light.
 */
#include "recurse/model/scene/plugIns.h"
#include "transport/direct/localShading.h"
#include "transport/learning/lightLearning.h"
#include "transport/paths/recordedCamera.h"
#include "transport/paths/walker.h"

namespace recurse {

namespace {

class RayCast final : public Integrator {
 public:
  explicit RayCast(const Rgb& ambient) : ambient(ambient) {}

  TransportCounts prepare(const Scene& scene, const PathClasses&) override {
    return learnLights(scene, lights);
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
    addAmbient(vertex, sampler, out);
  }

  std::string claims() const override { return "LD?E"; }
  std::string suppositions() const override {
    return isBlack(ambient)
               ? ""
               : "constant ambient light from all directions instead of light that surfaces reflect";
  }
  bool addsLightOfNoLamp() const override { return !isBlack(ambient); }
  std::vector<EstimatorDomain> domains() const override {
    std::vector<EstimatorDomain> all = {
        {"emission", "LE", "none: found by camera rays", "", true},
        {"shadow rays", "LDE", "one for each camera ray", "direct light"},
        {"BSDF rays", "LDE", "one for each camera ray", "direct light", true}};
    if (!isBlack(ambient)) all.push_back({"ambient term", "LDDE", "none: a constant", ""});
    return all;
  }

 private:
  /** Adds the ambient term, which counts as light with one earlier reflection (LDD). */
  void addAmbient(const CameraVertex& vertex, Sampler& sampler, PathRadiance& out) const {
    const PathClasses& classes = out.pathClasses();
    const LightState reflected = classes.step(classes.lightStart(), PathEvent::D);
    if (isBlack(ambient) || !vertex.isConnectable() || classes.join(reflected, vertex.afterD) == 0) return;
    const auto s = vertex.scattering->scatterNonDelta(vertex.wi, Transport::RADIANCE, sampler);
    if (!s) return;
    if (PathRecorder* recorder = out.recorder)
      recorder->source = {.technique = PathTechnique::AMBIENT, .vertex = recorder->source.vertex};
    out.add(reflected, vertex.afterD, ambient * s->weight);
  }

  Rgb ambient;
  LightSampler lights;
};

} // namespace

void registerRayCast(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "raycast",
        .summary = "Ray casting: surfaces that the camera sees directly, with direct light and shadows. "
                   "Mirrors and glass are black.",
        .parameters = {spectrumParameter("ambient", "0", SpectrumKind::UNBOUNDED,
                                         "constant ambient radiance, which replaces indirect light")},
        .examples = {"", "\"rgb ambient\" [.1 .1 .2]"}},
       [](const Parameters& p, const NoContext&) {
         return std::make_unique<RayCast>(Rgb(p.spectrum("ambient")));
       }});
}

} // namespace recurse
