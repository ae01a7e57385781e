/** @file
 * Local shading: the light that comes to a vertex straight from the lights, as ray casters and Whitted's
 * recursion need it.
 */
#pragma once

#include "transport/direct/directLight.h"
#include "transport/paths/pathVertex.h"

namespace recurse {

/**
 * Adds the light that arrives at a vertex without scattering on its way, thin panes included: one shadow ray
 * and one BSDF ray that share it by weights. `nesting` is what the walk is inside of that came to the vertex.
 */
void addDirectLight(const Scene& scene, const LightSampler& lights, const CameraVertex& vertex,
                    const Nesting& nesting, Sampler& sampler, PathRadiance& out);

/** Adds what the path's ray sees of a light that no shadow ray shares with it: `hit` emits, or is null where
 * the ray left the scene. */
void addSeenEmission(const Scene& scene, const LightSampler& lights, const CameraSubpath& path,
                     const Hit* hit, PathRadiance& out);

} // namespace recurse
