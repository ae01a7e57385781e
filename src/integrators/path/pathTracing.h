/** @file
 * Unbiased path tracer: shadow rays at every vertex, multiple importance sampling, Russian roulette. It
 * renders the references for the photon map.
 */
#pragma once

#include <memory>

#include "integrators/path/causticPhotons.h"
#include "integrators/path/plainPath.h"

namespace recurse {

/** Makes a path tracer. `caustics`: photons that share caustic paths, with only delta events between light
 * and non-delta surface, with its rays. `lights`: has learned the scene; null: the path tracer learns its
 * own. Both must outlive it. `guided`: learns the directions of incident light during the render. */
std::unique_ptr<Integrator> makePathTracing(const PlainPathSettings& settings,
                                            const CausticPhotons* caustics = nullptr,
                                            const LightSampler* lights = nullptr, bool guided = false);

} // namespace recurse
