/** @file
 * Direct light at a surface point: shadow rays towards sampled lights, and the weights that they share with
 * rays which the BSDF sends and which happen to meet a light (multiple importance sampling, Veach and Guibas
 * 1995).
 */
#pragma once

#include "recurse/model/scatteringPoint.h"
#include "recurse/transport/walk.h"

namespace recurse {

/** The power heuristic with exponent 2 (Veach 1997, section 9.2.4) for n samples of density p against one of
 * q. */
inline float powerHeuristic(int n, float p, float q) {
  const double a = double(n) * double(p), b = double(q);
  return static_cast<float>(a * a / (a * a + b * b));
}

/**
 * Adds the light that `samples` shadow rays bring to a point with non-delta lobes, seen from unit `eye` with
 * `throughput`. `eyeState` has read the D at the point. `allowed` are the lobes that the BSDF's own ray is
 * chosen from.
 */
void addSampledLight(const Scene& scene, const ScatteringPoint& scattering, const SurfacePoint& point,
                     const Vec3f& eye, const Rgb& throughput, EyeState eyeState, int samples, LobeSet allowed,
                     Sampler& sampler, PathRadiance& out);

/** What a BSDF ray carries to find the weight of the light that it may meet. */
struct BsdfRay {
  Vec3f from{0};
  float pdf = 0;         ///< per solid angle; of a non-delta lobe
  bool weighted = false; ///< false after the eye and after delta lobes: no shadow ray could find this light
};

/** The radiance of an emitting surface that a ray of unit `direction` met, times its weight; black when it
 * emits nothing there. */
Rgb emittedRadiance(const Scene& scene, const Hit& hit, const Vec3f& direction, const BsdfRay& ray,
                    int lightSamples);
/** The same for a ray that left the scene. */
Rgb environmentRadiance(const Scene& scene, const Vec3f& direction, const BsdfRay& ray, int lightSamples);

} // namespace recurse
