/** @file
 * Path tracer in its plain form, one path at a time, through surfaces and media (Kajiya 1986, "The Rendering
 * Equation", with the light sampling and MIS weights of Veach 1997, chapters 8 and 9).
 */
#pragma once

#include "transport/direct/lightSampler.h"

namespace recurse {

class GuideField;

struct PlainPathSettings {
  int maxDepth = -1;                 ///< maximum scattering events of a path; -1: no limit
  int lightSamples = 1;              ///< shadow rays at each vertex; 0: rays find lights by chance
  const GuideField* guide = nullptr; ///< learned density over directions; null: BSDF sampling
  bool sampleBsdf = true;            ///< false: uniform directions at opaque surfaces that are not mirrors
};

/** Adds the radiance along a camera ray to `out`. Lights are sampled by `lights`. */
void tracePlainPath(const Scene& scene, const CameraRay& ray, const LightSampler& lights,
                    const PlainPathSettings& settings, Sampler& sampler, PathRadiance& out);

/** Estimators of the plain path tracer, for Integrator::domains(). */
std::vector<EstimatorDomain> plainPathDomains(int lightSamples);

} // namespace recurse
