/** @file
 * Shadow rays as a PathRecorder is told of them.
 */
#pragma once

#include "recurse/model/light/light.h"
#include "recurse/transport/integrator/pathRecorder.h"

namespace recurse {

namespace recorded {

/** The weight that a technique gave: what it made of the radiance. */
inline float weightOf(const Rgb& weighted, const Rgb& whole) {
  const float largest = maxComponent(whole);
  return largest > 0 ? maxComponent(weighted) / largest : 0;
}

} // namespace recorded

/** Sets the source of a contribution: a shadow ray from `vertex` to a light. `pdf`: of all samples together,
 * `otherPdf` of the BSDF's ray. */
inline void recordLightSample(PathRecorder& recorder, int vertex, const LiSample& light, float pdf,
                              float otherPdf, float weight) {
  const bool isInfinite = !(light.distance < INFINITE);
  recorder.source = {.technique = PathTechnique::LIGHT_SAMPLE,
                     .vertex = vertex,
                     .step = recorder.source.step,
                     .end = isInfinite ? light.direction : light.target,
                     .isInfinite = isInfinite,
                     .weight = weight,
                     .pdf = light.delta ? 0 : pdf,
                     .otherPdf = light.delta ? 0 : otherPdf};
}

} // namespace recurse
