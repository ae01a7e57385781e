/** @file
 * Direct light at a surface point: shadow rays towards sampled lights, and the MIS weights that they
 * share with BSDF-sampled rays that happen to hit a light (multiple importance sampling, Veach and Guibas
 * 1995).
 */
#pragma once

#include <functional>

#include "recurse/model/bsdf/scatteringPoint.h"
#include "transport/direct/lightSampler.h"
#include "transport/paths/pathVertex.h"
#include "transport/paths/recordedSample.h"
#include "transport/paths/walk.h"

namespace recurse {

/** Power heuristic with exponent 2 (Veach 1997, section 9.2.4): weight of n samples of density p against one
 * sample of density q > 0. */
inline float powerHeuristic(int n, float p, float q) {
  return 1 / (1 + square(q / (static_cast<float>(n) * p))); // no square can overflow to a NaN
}

/** Context for choosing lights at a surface point, seen from unit `wi`. */
inline LightSampleContext lightSampleContext(const LightSampler& lightSampler, const SurfacePoint& point,
                                             const Vec3f& wi) {
  if (!lightSampler.active()) return {point.position};
  return lightSampler.at(point.position, point.normalTowards(wi));
}

/** Whether the scene has lights to sample, and some path class contains paths from them to a vertex with
 * `cameraState`, the state after its D event. */
inline bool lightIsSampled(const Scene& scene, const PathClasses& classes, CameraState cameraState) {
  return scene.lights().size() > 0 && classes.isLit(cameraState, hasPanes(scene));
}

/** Random numbers of one shadow ray, and the light that they select. */
struct SampledLight {
  const LightSampler* sampler;
  ChosenLight chosen;
  float pick; ///< uniform number left over by the choice of the light
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

/** Optical length of the path from a light sample through a surface, at which a walk has arrived from unit
 * `wi`, back to the walk's start [scene units]. */
inline float lengthToLight(const Scene& scene, const OpticalPath& optical, const ScatteringPoint& scattering,
                           const Vec3f& wi, const SurfacePoint& point, const LiSample& light) {
  return leaving(optical, scattering, wi, light.direction).at(distanceToLight(scene, point.position, light));
}

/** Contribution of one of `samples` shadow rays to a path seen from unit `wi`, without visibility, with MIS
 * weight and `throughput`. `probability`: of the choice of the light. If the contribution is black, the
 * shadow ray need not be traced. */
inline Rgb unshadowedRadiance(const ScatteringPoint& scattering, const Vec3f& wi, const Rgb& throughput,
                              const LiSample& light, float probability, int samples, LobeSet allowed) {
  if (!(light.pdf > 0)) return BLACK;
  const Rgb f = scattering.evaluate(wi, light.direction);
  if (isBlack(f)) return BLACK;
  const float pdf = probability * light.pdf;
  const float weight =
      light.unhittable ? 1 : powerHeuristic(samples, pdf, scattering.pdf(wi, light.direction, allowed));
  return throughput * f * light.radiance * (weight / (pdf * static_cast<float>(samples)));
}

/** Calls recordLightSample() with the MIS weight of unshadowedRadiance(), whose arguments these are. */
inline void recordLightSample(PathRecorder& recorder, int vertex, const ScatteringPoint& scattering,
                              const Vec3f& wi, const LiSample& light, float probability, int samples,
                              LobeSet allowed) {
  const float pdf = probability * light.pdf, bsdfPdf = scattering.pdf(wi, light.direction, allowed);
  recordLightSample(recorder, vertex, light, pdf * static_cast<float>(samples), bsdfPdf,
                    scattering.pdf(light.direction, wi, ALL_LOBES, Transport::FLUX),
                    light.unhittable ? 1 : powerHeuristic(samples, pdf, bsdfPdf));
}

/** MIS weight of the light of a shadow ray against other techniques than BSDF rays; `panes`: number of thin
 * panes passed. */
using ShadowRayWeight = std::function<float(const ChosenLight& light, const LiSample& sample, int panes)>;

/**
 * Adds the light of `samples` shadow rays at a point with non-delta lobes, through at most `maxPanes` thin
 * panes, seen from unit `wi` with `throughput`. `cameraState`: state after the D event at the point.
 * `allowed`: lobes from which the BSDF ray is sampled. `nesting`: state of the walk that arrived. `context`:
 * the point's context in `lightSampler`. The weights of BSDF rays that hit lights must not include densities
 * of media. `optical`: optical path of the walk on arrival. `weight`: empty for 1.
 */
void addSampledLight(const Scene& scene, const LightSampler& lightSampler, const LightSampleContext& context,
                     const ScatteringPoint& scattering, const Hit& hit, const Nesting& nesting,
                     const Vec3f& wi, const Rgb& throughput, CameraState cameraState, int samples,
                     LobeSet allowed, int maxPanes, Sampler& sampler, PathRadiance& out,
                     const OpticalPath& optical = {}, const ShadowRayWeight& weight = {});

/** BSDF ray, as needed for the MIS weight of a light that it hits, directly or straight through thin
 * panes. */
struct BsdfRay {
  LightSampleContext from;
  float pdf = 0;         ///< density of the direction by a non-delta lobe [1/sr]
  bool weighted = false; ///< false after the camera and after delta lobes other than panes, where no shadow
                         ///< ray samples this light
};

/** Emission that a camera ray has found: of a surface, or of an environment light as it left the scene. */
struct LightHit {
  uint32_t index = 0; ///< index of the light in LightTable
  const Light* light = nullptr;
  const Hit* hit = nullptr; ///< null for an environment light
  LeRay emitted;            ///< reversed ray, as the light emits it
  Rgb radiance;             ///< towards the ray's origin
  float beyond = 0;         ///< distance of the light from the end of the path [scene units]
  float shadowRays = 0;     ///< density of the shadow rays that compete [1/sr]
  Rgb weighted;             ///< radiance times its MIS weight
};
/** Emission of the surface `hit`, or if it is null of environment light number `which`. `from`: the ray as it
 * left its last non-delta vertex, with `samples` shadow rays. `inMedia`: spectral densities of the path;
 * null: weights ignore media. */
LightHit lightHit(const Scene& scene, const LightSampler& lights, const Hit* hit, size_t which,
                  const Ray& ray, const BsdfRay& from, int samples, const SpectralPath* inMedia);
/** Calls visit(const LightHit&) for the emission of the surface `hit`, or if it is null of each environment
 * light. */
template <class Visit>
void forLightHits(const Scene& scene, const LightSampler& lights, const Hit* hit, const Ray& ray,
                  const BsdfRay& from, int samples, const SpectralPath* inMedia, const Visit& visit) {
  const size_t count = hit ? 1 : scene.environment().size();
  for (size_t i = 0; i < count; ++i) {
    const LightHit found = lightHit(scene, lights, hit, i, ray, from, samples, inMedia);
    if (!isBlack(found.radiance)) visit(found);
  }
}

/** Adds the light of one sample of light number `index` at a vertex, through media and at most `maxPanes`
 * thin panes. `path`: up to the vertex. `hasRay`: the path goes on by a ray that may hit the light. `pdf`:
 * density of all samples together, including the choice of the light. */
void addLightInMedia(const Scene& scene, const CameraSubpath& path, const CameraVertex& vertex, bool hasRay,
                     const LiSample& light, uint32_t index, float pdf, int maxPanes, Sampler& sampler,
                     PathRadiance& out);

/** Variant of addSampledLight() for scenes with media, for a walk that weights the lights it hits as
 * lightHit() does if it `hasRay`. */
void addSampledLightInMedia(const Scene& scene, const LightSampler& lightSampler,
                            const LightSampleContext& context, const CameraSubpath& path,
                            const CameraVertex& vertex, bool hasRay, int samples, int maxPanes,
                            Sampler& sampler, PathRadiance& out);

/** Adds the light of `samples` shadow rays at a connectable vertex of a camera path, at a surface or in a
 * medium, through at most `maxPanes` thin panes. `context`: of the vertex in `lightSampler`. */
inline void addDirectLight(const Scene& scene, const LightSampler& lightSampler,
                           const LightSampleContext& context, const CameraSubpath& path,
                           const CameraVertex& vertex, int samples, int maxPanes, Sampler& sampler,
                           PathRadiance& out) {
  if (scene.hasMedia())
    addSampledLightInMedia(scene, lightSampler, context, path, vertex, true, samples, maxPanes, sampler, out);
  else
    addSampledLight(scene, lightSampler, context, *vertex.scattering, vertex.hit, path.nesting, vertex.wi,
                    vertex.throughput, vertex.afterD, samples, ALL_LOBES, maxPanes, sampler, out,
                    path.optical);
}

/** Context for choosing lights at a vertex. */
inline LightSampleContext lightSampleContext(const LightSampler& lightSampler, const CameraVertex& vertex) {
  if (vertex.medium) return {vertex.point().position};
  return lightSampleContext(lightSampler, vertex.point(), vertex.wi);
}

/** Sets the source of a contribution: light that a ray found which left by `step`. */
inline void recordHit(PathRecorder& recorder, int step, const LightHit& found, const BsdfRay& ray) {
  RecordedSource& s = recorder.source;
  s = {.technique = PathTechnique::HIT, .vertex = s.vertex, .step = step};
  s.end = found.hit ? found.hit->point.position : -found.emitted.direction;
  s.isInfinite = !found.hit;
  s.weight = recorded::weightOf(found.weighted, found.radiance);
  if (!ray.weighted) return;
  s.pdf = ray.pdf;
  s.otherPdf = found.shadowRays;
}

} // namespace recurse
