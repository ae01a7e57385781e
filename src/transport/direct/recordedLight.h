/** @file
 * Recording of light hits by a PathRecorder.
 */
#pragma once

#include "recurse/transport/integrator/pathRecorder.h"
#include "transport/direct/directLight.h"

namespace recurse {

/** Sets the source of a contribution: light that a ray found which left by `step`. */
inline void recordHit(PathRecorder& recorder, int step, const LightHit& found, const BsdfRay& ray) {
  RecordedSource& s = recorder.source;
  s = {.technique = PathTechnique::HIT, .vertex = s.vertex, .step = step};
  s.end = found.hit ? found.hit->point.position : -found.emitted.direction;
  s.isInfinite = !found.hit;
  s.weight = recorded::weightOf(found.weighted, found.radiance);
  if (!ray.weighted) return;
  s.pdf = ray.pdf;
  s.otherPdf = found.shadowRays;
}

} // namespace recurse
