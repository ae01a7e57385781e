/** @file
 * Estimators of direct light at a point: one ray by one density.
 */
#pragma once

#include "recurse/core/sampling/sampler.h"
#include "report/figures/visiblePoints.h"

namespace recurse {

/** Density from which the direction of a ray is sampled. */
enum class DirectSampling {
  UNIFORM,  ///< equal over the hemisphere, or over the sphere where the surface transmits light
  COSINE,   ///< in proportion to the cosine with the normal, on both sides where the surface transmits light
  BSDF,     ///< the BSDF's own
  LIGHT,    ///< light sampling: a light by power, then a point of it
  COMBINED, ///< BSDF or light, each with probability 1/2: one-sample balance heuristic (Veach 1997, 9.2.4)
};
constexpr int DIRECT_SAMPLINGS = 5;
const char* directSamplingName(DirectSampling sampling);

/**
 * One-sample estimate of the direct light that a point reflects to the camera, throughput included. Light of
 * points and in single directions, which no ray hits, is estimated by LIGHT and COMBINED only.
 */
Rgb sampleDirectLight(const Scene& scene, const ViewedPoint& point, DirectSampling sampling,
                      Sampler& sampler);

} // namespace recurse
