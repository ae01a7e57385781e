/** @file
 * The unbiased path tracer: shadow rays at every vertex, multiple importance sampling, Russian roulette. It
 * is the truth that the photon map is compared with.
 */
#pragma once

#include <memory>

#include "recurse/transport/causticPhotons.h"
#include "recurse/transport/plainPath.h"

namespace recurse {

/** A path tracer; with `caustics`, which must outlive it, photons of those share with its rays what comes by
 * mirrors and glass alone to a non-delta surface. Their owner runs their passes. */
std::unique_ptr<Integrator> makePathTracing(const PlainPathSettings& settings,
                                            const CausticPhotons* caustics = nullptr);

} // namespace recurse
