/** @file
 * Direct light at a surface point: shadow rays towards sampled lights, and the weights that they share with
 * rays which the BSDF sends and which happen to meet a light (multiple importance sampling, Veach and Guibas
 * 1995).
 */
#pragma once

#include "recurse/model/bsdf/scatteringPoint.h"
#include "transport/direct/lightSampler.h"
#include "transport/paths/walk.h"

namespace recurse {

/** The power heuristic with exponent 2 (Veach 1997, section 9.2.4) for n samples of density p against one of
 * q > 0. */
inline float powerHeuristic(int n, float p, float q) {
  return 1 / (1 + square(q / (static_cast<float>(n) * p))); // no square that could overflow to a NaN
}

/** What a light sampler knows of a surface point, seen from unit `wi`. */
inline LightSampleContext lightSampleContext(const LightSampler& lightSampler, const SurfacePoint& point,
                                             const Vec3f& wi) {
  if (!lightSampler.active()) return {point.position};
  return lightSampler.at(point.position, point.normalTowards(wi));
}

/** What the light's side of a path has read behind so many thin panes. */
inline LightState afterPanes(const PathClasses& classes, int panes) {
  LightState state = classes.lightStart();
  for (; panes > 0; --panes) state = classes.step(state, PathEvent::S);
  return state;
}

/** Whether there are lights to be sampled, and paths from them in demand, at a vertex whose D `cameraState`
 * has read. */
inline bool lightIsSampled(const Scene& scene, const PathClasses& classes, CameraState cameraState) {
  if (scene.lights().size() == 0) return false;
  // After as many steps as there are states nothing new comes.
  const int panes = hasPanes(scene) ? static_cast<int>(classes.lightStateCount()) : 0;
  LightState state = classes.lightStart();
  for (int i = 0; i <= panes; ++i, state = classes.step(state, PathEvent::S))
    if (classes.join(state, cameraState) != 0) return true;
  return false;
}

/** The numbers of one shadow ray, and the light that they choose. */
struct SampledLight {
  const LightSampler* sampler;
  ChosenLight chosen;
  float pick; ///< what the choice left over
  Vec2f u;

  SampledLight(const LightTable& lights, const LightSampler& lightSampler, const LightSampleContext& context,
               Sampler& random)
      : sampler(&lightSampler), pick(random.next1D()), u(random.next2D()) {
    chosen = lightSampler.choose(lights, context, pick);
  }
  std::optional<LiSample> sampleLi(const SurfacePoint& point) const {
    if (chosen.probability > 0) return sampler->sampleLi(*chosen.light, point.time, point.position, pick, u);
    return {};
  }
};

/** What one of `samples` shadow rays brings along unit `wi`, times `throughput`, if nothing is in its way.
 * Black: it need not be traced. */
inline Rgb unshadowedRadiance(const ScatteringPoint& scattering, const Vec3f& wi, const Rgb& throughput,
                              const LiSample& light, float probability, int samples, LobeSet allowed) {
  if (!(light.pdf > 0)) return BLACK;
  const Rgb f = scattering.evaluate(wi, light.direction);
  if (isBlack(f)) return BLACK;
  const float pdf = probability * light.pdf;
  const float weight =
      light.delta ? 1 : powerHeuristic(samples, pdf, scattering.pdf(wi, light.direction, allowed));
  return throughput * f * light.radiance * (weight / (pdf * static_cast<float>(samples)));
}

/**
 * Adds the light that `samples` shadow rays bring to a point with non-delta lobes, past at most `maxPanes`
 * thin panes, seen from unit `wi` with `throughput`. `cameraState` has read the D at the point. `allowed`
 * are the lobes that the BSDF's own ray is chosen from, `nesting` is what the walk is inside of that came
 * there. `context` is the point as `lightSampler` knows it. Media on the way have to be homogeneous; the
 * light that a BSDF ray meets is to be weighed without them.
 */
void addSampledLight(const Scene& scene, const LightSampler& lightSampler, const LightSampleContext& context,
                     const ScatteringPoint& scattering, const Hit& hit, const Nesting& nesting,
                     const Vec3f& wi, const Rgb& throughput, CameraState cameraState, int samples,
                     LobeSet allowed, int maxPanes, Sampler& sampler, PathRadiance& out);

/** What a BSDF ray carries to find the weight of the light that it may meet, at once or straight through thin
 * panes. */
struct BsdfRay {
  LightSampleContext from;
  float pdf = 0;         ///< per solid angle; of a non-delta lobe
  bool weighted = false; ///< false after the camera and after delta lobes other than panes: no shadow ray
                         ///< could find this light
};

/** The radiance of an emitting surface that a ray of unit `direction` met, times its weight; black when it
 * emits nothing there. `inMedia`, in scenes with media: the densities of the path. */
Rgb emittedRadiance(const Scene& scene, const LightSampler& lightSampler, const Hit& hit,
                    const Vec3f& direction, const BsdfRay& ray, int lightSamples,
                    const SpectralPath* inMedia = nullptr);
/** The same for a ray that left the scene, of one of its lights. */
Rgb environmentRadiance(const Scene& scene, const LightSampler& lightSampler, size_t which,
                        const Vec3f& direction, const BsdfRay& ray, int lightSamples,
                        const SpectralPath* inMedia = nullptr);
/** Of all of them. */
Rgb environmentRadiance(const Scene& scene, const LightSampler& lightSampler, const Vec3f& direction,
                        const BsdfRay& ray, int lightSamples, const SpectralPath* inMedia = nullptr);

/** Where shadow rays start in a scene with media: on a surface or in a medium. */
struct LitVertex {
  const Hit& hit;
  const ScatteringPoint* scattering; ///< null in a medium
  const Medium* medium;              ///< null at a surface
  Vec3f wi;                          ///< unit, towards where the walk came from
  LobeSet allowed;                   ///< as for addSampledLight
  const Nesting& nesting;
  const SpectralPath& path; ///< that arrived
  int hero;
  CameraState state;      ///< which has read the event
  bool hasBsdfRay = true; ///< false: nothing but shadow rays finds light from here

  /** What it sends along the walk of light from unit `light`, the cosine included. */
  Rgb value(const Vec3f& light) const {
    return medium ? Rgb(medium->phase->value(glm::dot(-wi, light))) : scattering->evaluate(wi, light);
  }
  float pdf(const Vec3f& light) const {
    return medium ? medium->phase->value(glm::dot(-wi, light)) : scattering->pdf(wi, light, allowed);
  }
};

/** Adds the light of one sample, if nothing but media and at most `maxPanes` thin panes is in its way. `pdf`
 * is that of all samples together, of what was chosen to find it. */
void addLightInMedia(const Scene& scene, const LitVertex& vertex, const LiSample& light, float pdf,
                     int maxPanes, Sampler& sampler, PathRadiance& out);

/** addSampledLight in a scene with media, for a walk that goes on by the BSDF or the phase function and
 * weighs the lights that it meets with emittedRadiance and environmentRadiance. */
void addSampledLightInMedia(const Scene& scene, const LightSampler& lightSampler,
                            const LightSampleContext& context, const LitVertex& vertex, int samples,
                            int maxPanes, Sampler& sampler, PathRadiance& out);

} // namespace recurse
