/** @file
 * The unbiased path tracer: shadow rays at every vertex, multiple importance sampling, Russian roulette. It
 * is the truth that the photon map is compared with.
 */
#pragma once

#include <memory>

#include "integrators/path/causticPhotons.h"
#include "integrators/path/plainPath.h"

namespace recurse {

/** A path tracer. With `caustics`, photons of those share with its rays what comes by mirrors and glass alone
 * to a non-delta surface. `lights` has learned the scene; null: the path tracer learns its lights itself.
 * Both must outlive it. `guided`: it learns as it goes on from which directions light arrives. */
std::unique_ptr<Integrator> makePathTracing(const PlainPathSettings& settings,
                                            const CausticPhotons* caustics = nullptr,
                                            const LightSampler* lights = nullptr, bool guided = false);

} // namespace recurse
