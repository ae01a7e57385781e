/** @file
 * Local shading: direct illumination of a vertex without further bounces, for ray casting and Whitted ray
 * tracing.
 */
#pragma once

#include "transport/direct/directLight.h"
#include "transport/paths/pathVertex.h"

namespace recurse {

/**
 * Adds the direct light of a vertex: one shadow ray and one BSDF ray, combined by MIS weights. Thin panes
 * occlude it. `nesting`: state of the walk that arrived at the vertex, which is the latest of a recorder.
 */
void addDirectLight(const Scene& scene, const LightSampler& lights, const CameraVertex& vertex,
                    const Nesting& nesting, Sampler& sampler, PathRadiance& out);

/** Adds emission that the path's ray sees. `hit` is the emitting surface, or null where the ray left the
 * scene. `step`: of the recorded path, by which the ray left. `ray`: MIS weights against one shadow ray;
 * default: weight 1. */
void addSeenEmission(const Scene& scene, const LightSampler& lights, const CameraSubpath& path,
                     const Hit* hit, int step, PathRadiance& out, const BsdfRay& ray = {});

} // namespace recurse
