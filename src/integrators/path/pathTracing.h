/** @file
 * Unbiased path tracer: shadow rays at every vertex, multiple importance sampling, Russian roulette. It
 * renders the references for the photon map.
 */
#pragma once

#include <memory>

#include "integrators/path/plainPath.h"

namespace recurse {

/** Makes a path tracer. `lights`: has learned the scene and must outlive the path tracer; null: it learns its
 * own. `guided`: learns the directions of incident light during the render. */
std::unique_ptr<Integrator> makePathTracing(const PlainPathSettings& settings,
                                            const LightSampler* lights = nullptr, bool guided = false);

} // namespace recurse
