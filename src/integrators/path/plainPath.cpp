/** @file
 * Plain path tracer: one path at a time.
 */
#include "integrators/path/plainPath.h"

#include "recurse/transport/integrator/lightPathRecorder.h"
#include "transport/direct/directLight.h"
#include "transport/learning/guideTraining.h"
#include "transport/paths/recordedCamera.h"
#include "transport/paths/walker.h"

namespace recurse {

namespace {

/** Uniform density over the directions of a hemisphere. */
class UniformGuide final : public DirectionGuide {
 public:
  explicit UniformGuide(const Vec3f& normal) : frame(normal) {}

  float pdf(const Vec3f& direction) const override { return glm::dot(direction, frame.z) > 0 ? DENSITY : 0; }
  Vec3f sample(Vec2f u, float& density) const override {
    density = DENSITY;
    return frame.toWorld(uniformCone(u, 1));
  }
  float bsdfProbability() const override { return 0; }

 private:
  static constexpr float DENSITY = INV_PI / 2;
  Frame frame;
};

/** A path from the camera, with the state that its estimators share. */
class PlainPath {
 public:
  PlainPath(const Scene& scene, const CameraRay& ray, const LightSampler& lights,
            const PlainPathSettings& settings, Sampler& sampler, PathRadiance& out)
      : scene(scene), classes(out.pathClasses()), lights(lights), settings(settings), sampler(sampler),
        out(out), walker(scene, classes, out.counts, settings.maxDepth),
        path(startCameraSubpath(scene, classes, ray, out.counts)), record(out.recorder) {
    if (scene.hasMedia()) path.hero = drawHero(sampler.next1D());
  }

  void trace() {
    const auto emission = [&](const Hit* hit) { addEmission(hit); };
    const auto mediumEmission = [&](const Rgb& radiance) { addMediumEmission(radiance); };
    while (walker.next(path, vertex, sampler, emission, mediumEmission)) {
      record.arrive(vertex);
      chooseDirections();
      LightSampleContext context{vertex.point().position};
      if (vertex.isConnectable()) {
        context = lightSampleContext(lights, vertex);
        addDirectLight(scene, lights, context, path, vertex, settings.lightSamples,
                       panesLeft(settings.maxDepth, vertex.depth), sampler, out);
      }
      const std::optional<Scatter> s = walker.scatter(path, vertex, sampler);
      if (!s) return;
      record.leave(vertex, *s, path.throughput);
      leave(*s, context);
    }
  }

 private:
  void add(LightState light, const Rgb& radiance, float length) {
    if (isScattered)
      out.add(light, path.state, radiance, length);
    else
      out.addSeen(light, path.state, radiance, length);
  }
  /** Adds the emission of a surface, or of the environment lights if `hit` is null. */
  void addEmission(const Hit* hit) {
    forLightHits(scene, lights, hit, path.ray, last, settings.lightSamples,
                 scene.hasMedia() ? &path : nullptr, [&](const LightHit& found) {
                   if (out.recorder) recordHit(*out.recorder, record.step(), found, last);
                   add(classes.lightStart(found.index), path.throughput * found.weighted,
                       path.optical.at(found.beyond));
                 });
  }
  void recordMediumEmission() const {
    Hit end;
    const bool isHit = scene.intersect(path.ray, end);
    recordFlight(*out.recorder, record.step(), path.ray, isHit ? end.t : INFINITE);
  }
  void addMediumEmission(const Rgb& radiance) {
    if (out.recorder) recordMediumEmission();
    add(startInMedium(scene, classes, path.nesting.medium(scene)), radiance, path.optical.length);
  }

  /** Replaces BSDF sampling of the next direction: by the mixture with the guide, or by a uniform density. */
  void chooseDirections() {
    if (settings.guide) followGuide(*settings.guide, vertex);
    if (!settings.sampleBsdf && !vertex.medium)
      vertex.scattering->follow(&uniform.emplace(vertex.point().normalTowards(vertex.wi)));
  }

  /** Sets the MIS weights of light that the ray from the vertex hits, against light samples in `context`. */
  void leave(const Scatter& s, const LightSampleContext& context) {
    isScattered = isScattered || !path.delta;
    if (vertex.medium || !passesPane(scene, *vertex.scattering, s))
      last = {context, static_cast<float>(path.pdf), !path.delta};
  }

  const Scene& scene;
  const PathClasses& classes;
  const LightSampler& lights;
  const PlainPathSettings& settings;
  Sampler& sampler;
  PathRadiance& out;
  CameraWalker walker;
  CameraSubpath path;
  CameraVertex vertex;
  std::optional<UniformGuide> uniform; ///< guide at the vertex, if BSDFs are not sampled
  BsdfRay last;                        ///< ray that left the last vertex, panes aside
  bool isScattered = false;            ///< has passed a non-delta vertex
  RecordedCameraPath record;
};

} // namespace

void tracePlainPath(const Scene& scene, const CameraRay& ray, const LightSampler& lights,
                    const PlainPathSettings& settings, Sampler& sampler, PathRadiance& out) {
  PlainPath(scene, ray, lights, settings, sampler, out).trace();
}

std::vector<EstimatorDomain> plainPathDomains(int lightSamples) {
  if (lightSamples == 0)
    return {{"emission", "LS*E", "none: found by camera rays through mirrors and glass", "", true},
            {"emission after scattering", "LS*(D|V)(S|D|V)*E", "none: found by continued rays", "", true}};
  return {{"emission", "LS*E", "none: found by camera rays through mirrors and glass", "", true},
          {"emission after scattering", "LS+(D|V)(S|D|V)*E", "none: found by continued rays",
           "direct light through panes", true},
          {"shadow rays through panes", "LS+(D|V)(S|D|V)*E", "included in shadow rays",
           "direct light through panes", false, true},
          {"shadow rays", "L(D|V)(S|D|V)*E",
           std::to_string(lightSamples) + " for each diffuse vertex, and where a medium scatters",
           "direct light"},
          {"BSDF rays", "L(D|V)(S|D|V)*E", "included in continued rays", "direct light", true}};
}

} // namespace recurse
