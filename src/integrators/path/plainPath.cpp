/** @file
 * Plain path tracer: one path at a time.
 */
#include "integrators/path/plainPath.h"

#include "integrators/path/causticPhotons.h"
#include "recurse/transport/integrator/lightPathRecorder.h"
#include "transport/direct/recordedLight.h"
#include "transport/learning/guideTraining.h"
#include "transport/paths/walker.h"

namespace recurse {

namespace {

int recordVertex(PathRecorder& recorder, int step, const CameraVertex& vertex) {
  if (!vertex.medium)
    return recorder.addVertex(step, vertex.hit, -vertex.wi, vertex.scattering->lobes(), vertex.throughput);
  return recorder.addVertex(
      {.step = step, .position = vertex.point().position, .inMedium = true, .throughput = vertex.throughput});
}

RecordedStep recordedStepOf(int recorded, const CameraVertex& vertex, const Scatter& s,
                            const Rgb& throughput) {
  RecordedStep step{.vertex = recorded,
                    .event = vertex.medium  ? PathEvent::V
                             : s.specular() ? PathEvent::S
                                            : PathEvent::D,
                    .lobe = s.lobe,
                    .direction = s.direction,
                    .throughput = throughput};
  if (!s.specular()) {
    step.pdf = s.pdf;
    step.pdfReverse = vertex.medium ? s.pdf : vertex.scattering->pdf(s.direction, vertex.wi);
  }
  return step;
}

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

} // namespace

void tracePlainPath(const Scene& scene, const CameraRay& ray, const LightSampler& lights,
                    const PlainPathSettings& settings, Sampler& sampler, PathRadiance& out,
                    const CausticPhotons* caustics) {
  const PathClasses& classes = out.pathClasses();
  CameraWalker walker(scene, classes, out.counts, settings.maxDepth);
  CameraSubpath path = startCameraSubpath(scene, classes, ray, out.counts);
  if (scene.hasMedia()) path.hero = std::min(2, static_cast<int>(3 * sampler.next1D()));
  CameraVertex vertex;
  BsdfRay last;
  CausticRay caustic;
  bool isScattered = false;
  PathRecorder* recorder = out.recorder;
  int recordedStep = CAMERA_STEP;
  const auto add = [&](LightState light, const Rgb& radiance, float length) {
    if (isScattered)
      out.add(light, path.state, radiance, length);
    else
      out.addSeen(light, path.state, radiance, length);
  };
  const auto addEmission = [&](const Hit* hit) {
    const Vec3f& direction = path.ray.direction;
    const SpectralPath spectral = path.spectral();
    const SpectralPath* inMedia = scene.hasMedia() ? &spectral : nullptr;
    const bool shared = caustics && isScattered && !last.weighted;
    if (hit) {
      const Rgb emitted =
          emittedRadiance(scene, lights, *hit, direction, last, settings.lightSamples, inMedia);
      if (isBlack(emitted)) return;
      const float weight = shared ? caustics->rayWeight(scene, caustic.ratio(), *hit, direction) : 1;
      if (recorder)
        recordHit(*recorder, recordedStep, scene, lights, *hit, direction, last, emitted * weight);
      add(classes.lightStart(hit->lightIndex), path.throughput * emitted * weight, path.optical.length);
      return;
    }
    const float length = path.optical.at(lengthFromInfinity(scene, path.ray.origin, direction));
    for (size_t i = 0; i < scene.environment().size(); ++i) {
      const Rgb emitted =
          environmentRadiance(scene, lights, i, direction, last, settings.lightSamples, inMedia);
      if (isBlack(emitted)) continue;
      const float weight = shared ? caustics->rayWeight(scene, caustic.ratio(), i, path.ray) : 1;
      if (recorder) recordHit(*recorder, recordedStep, scene, lights, i, direction, last, emitted * weight);
      add(classes.lightStart(scene.environmentIndices()[i]), path.throughput * emitted * weight, length);
    }
  };
  const auto addMediumEmission = [&](const Rgb& radiance) {
    if (recorder)
      recorder->source = {.technique = PathTechnique::HIT, .step = recordedStep, .end = path.from};
    add(startInMedium(scene, classes, path.nesting.medium(scene)), radiance, path.optical.length);
  };
  while (walker.next(path, vertex, sampler, addEmission, addMediumEmission)) {
    const int recorded = recorder ? recordVertex(*recorder, recordedStep, vertex) : NOT_RECORDED;
    if (settings.guide && !vertex.medium)
      vertex.scattering->follow(guideAt(*settings.guide, vertex.point(), vertex.wi));
    std::optional<UniformGuide> uniform;
    if (!settings.sampleBsdf && !vertex.medium)
      vertex.scattering->follow(&uniform.emplace(vertex.point().normalTowards(vertex.wi)));
    LightSampleContext lightContext{vertex.point().position};
    if (vertex.isConnectable()) {
      if (!vertex.medium) lightContext = lightSampleContext(lights, vertex.point(), vertex.wi);
      const int panes = panesLeft(settings.maxDepth, vertex.depth);
      if (scene.hasMedia())
        addSampledLightInMedia(scene, lights, lightContext,
                               {vertex.hit, vertex.medium ? nullptr : &*vertex.scattering, vertex.medium,
                                vertex.wi, ALL_LOBES, path.nesting, path.spectral(), path.hero, vertex.afterD,
                                true, path.optical},
                               settings.lightSamples, panes, sampler, out);
      else
        addSampledLight(scene, lights, lightContext, *vertex.scattering, vertex.hit, path.nesting, vertex.wi,
                        vertex.throughput, vertex.afterD, settings.lightSamples, ALL_LOBES, panes, sampler,
                        out, path.optical);
    }
    float merging = 0;
    if (caustics && vertex.isConnectable() && !vertex.medium)
      merging = caustics->add(scene, vertex.point(), vertex.wi, *vertex.scattering, vertex.throughput,
                              vertex.afterD, path.width, path.optical, sampler, out);
    const std::optional<Scatter> s = walker.scatter(path, vertex, sampler);
    if (!s) break;
    if (recorder) recordedStep = recorder->addStep(recordedStepOf(recorded, vertex, *s, path.throughput));
    if (!path.delta)
      caustic.leaveNonDelta(merging,
                            merging > 0 ? vertex.scattering->pdfNonDelta(vertex.wi, s->direction) : 1,
                            s->direction, vertex.point());
    else
      caustic.leaveDelta(-vertex.wi, s->direction, vertex.point());
    isScattered = isScattered || !path.delta;
    if (vertex.medium || !passesPane(scene, *vertex.scattering, *s))
      last = {lightContext, static_cast<float>(path.pdf), !path.delta};
  }
}

std::vector<EstimatorDomain> plainPathDomains(int lightSamples) {
  if (lightSamples == 0)
    return {{"emission", "LS*E", "none: found by camera rays through mirrors and glass", "", true},
            {"emission after scattering", "LS*(D|V)(S|D|V)*E", "none: found by continued rays", "", true}};
  return {{"emission", "LS*E", "none: found by camera rays through mirrors and glass", "", true},
          {"emission after scattering", "LS+(D|V)(S|D|V)*E", "none: found by continued rays",
           "direct light through panes", true},
          {"shadow rays through panes", "LS+(D|V)(S|D|V)*E",
           "none: the shadow rays, straight through thin panes", "direct light through panes", false, true},
          {"shadow rays", "L(D|V)(S|D|V)*E",
           std::to_string(lightSamples) + " for each diffuse vertex, and where a medium scatters",
           "direct light"},
          {"BSDF rays", "L(D|V)(S|D|V)*E", "none: the continued rays", "direct light", true}};
}

} // namespace recurse
