/** @file
 * The path tracer, for integrators that leave pictures to it.
 */
#pragma once

#include <memory>

#include "recurse/transport/integrator.h"

namespace recurse {

/** `maxDepth`: most scattering events of a path, -1: no limit; `lightSamples`: shadow rays at each vertex. */
std::unique_ptr<Integrator> makePath(int maxDepth, int lightSamples);

} // namespace recurse
