/** @file
 * Ambient occlusion (Zhukov, Iones, Kronin 1998, "An Ambient Light Illumination Model"): the fraction of a
 * uniform white sky that reaches a visible surface.
 */
#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"
#include "transport/paths/recordedCamera.h"
#include "transport/paths/walker.h"

namespace recurse {

namespace {

class AmbientOcclusion final : public Integrator {
 public:
  explicit AmbientOcclusion(float maxDistance) : maxDistance(maxDistance) {}

  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    const PathClasses& classes = out.pathClasses();
    CameraWalker walker(scene, classes, out.counts, 1);
    CameraSubpath path = startCameraSubpath(scene, classes, ray, out.counts);
    CameraVertex vertex;
    if (!walker.next(path, vertex, sampler) || classes.join(classes.lightStart(), vertex.afterD) == 0) return;
    const SurfacePoint& point = vertex.point();
    const float side = glm::dot(point.shadingNormal, vertex.wi) < 0 ? -1.0f : 1.0f;
    const Vec3f direction = Frame(point.shadingNormal * side).toWorld(cosineHemisphere(sampler.next2D()));
    // Shading normals may send directions below the geometric surface, where no sky is visible.
    if (glm::dot(direction, point.geometricNormal) * glm::dot(vertex.wi, point.geometricNormal) <= 0) return;
    Ray towardsSky = spawn(point, direction);
    towardsSky.tMax = maxDistance;
    ++out.counts.rays;
    if (scene.occluded(towardsSky)) return;
    if (out.recorder) recordSky(vertex, direction, *out.recorder);
    out.add(classes.lightStart(), vertex.afterD, Rgb(1));
  }

  std::string claims() const override { return "LDE"; }
  std::string suppositions() const override {
    return std::string("white light of constant radiance from all directions instead of the lights, and "
                       "white diffuse surfaces") +
           (maxDistance < INFINITE ? "; surfaces beyond \"maxdistance\" do not occlude" : "");
  }
  bool addsLightOfNoLamp() const override { return true; }
  std::vector<EstimatorDomain> domains() const override {
    return {{"occlusion rays", "LDE", "one for each camera ray", ""}};
  }

 private:
  /** Records the path from the sky in unit `direction`. */
  static void recordSky(const CameraVertex& vertex, const Vec3f& direction, PathRecorder& recorder) {
    RecordedCameraPath record(&recorder);
    record.arrive(vertex);
    const float pdf = absDot(direction, vertex.point().shadingNormal) * INV_PI;
    const int step =
        recorder.addStep({.vertex = record.vertex(),
                          .lobe = REFLECTION,
                          .direction = direction,
                          .pdf = pdf,
                          .pdfReverse = absDot(vertex.wi, vertex.point().shadingNormal) * INV_PI});
    recorder.source = {.technique = PathTechnique::HIT,
                       .vertex = record.vertex(),
                       .step = step,
                       .end = direction,
                       .isInfinite = true,
                       .pdf = pdf};
  }

  float maxDistance;
};

} // namespace

void registerAmbientOcclusion(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "ambientocclusion",
        .summary = "Ambient occlusion: the fraction of a uniform white sky that reaches each visible point. "
                   "The scene's lights and materials are ignored.",
        .parameters = {realParameter(
                           "maxdistance", "",
                           "maximum distance of an occluding surface [scene units]; by default infinite")
                           .positive(),
                       ignoredParameter(ParameterType::BOOLEAN, "cossample",
                                        "directions are always sampled by the cosine")},
        .examples = {"", "\"float maxdistance\" 2"}},
       [](const Parameters& p, const NoContext&) {
         return std::make_unique<AmbientOcclusion>(
             p.hasValue("maxdistance") ? static_cast<float>(p.real("maxdistance")) : INFINITE);
       }});
}

} // namespace recurse
