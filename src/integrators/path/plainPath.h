/** @file
 * A path tracer to be read: one path after the other, through surfaces and media (Kajiya 1986, "The Rendering
 * Equation", with the shadow rays and weights of Veach 1997, chapters 8 and 9).
 */
#pragma once

#include "transport/direct/lightSampler.h"

namespace recurse {

class CausticPhotons;
class GuideField;

struct PlainPathSettings {
  int maxDepth = -1;                 ///< most scattering events of a path; -1: no limit
  int lightSamples = 1;              ///< shadow rays at each vertex
  const GuideField* guide = nullptr; ///< learned density over directions; null: BSDF sampling
};

/** The radiance along a ray from the camera. Lights are sampled by `lights`; for `caustics` see
 * makePathTracing(). */
void tracePlainPath(const Scene& scene, const CameraRay& ray, const LightSampler& lights,
                    const PlainPathSettings& settings, Sampler& sampler, PathRadiance& out,
                    const CausticPhotons* caustics = nullptr);

/** What it does, for Integrator::domains(). */
std::vector<EstimatorDomain> plainPathDomains(int lightSamples);

} // namespace recurse
