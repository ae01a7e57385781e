/** @file
 * Recording of steps and shadow rays for a PathRecorder.
 */
#pragma once

#include "recurse/model/bsdf/bsdf.h"
#include "recurse/model/light/light.h"
#include "recurse/transport/integrator/pathRecorder.h"

namespace recurse {

namespace recorded {

/** MIS weight of a technique: the ratio of the weighted to the unweighted radiance. */
inline float weightOf(const Rgb& weighted, const Rgb& whole) {
  const float largest = maxComponent(whole);
  return largest > 0 ? maxComponent(weighted) / largest : 0;
}

} // namespace recorded

/** Step from `vertex` by a BSDF sample. `throughput`, `pdfReverse`: see RecordedStep. */
inline RecordedStep recordedStep(int vertex, const Scatter& s, const Rgb& throughput, float pdfReverse) {
  const bool isDelta = s.specular();
  return {vertex,
          isDelta ? PathEvent::S : PathEvent::D,
          s.lobe,
          s.direction,
          throughput,
          isDelta ? 0 : s.pdf,
          isDelta ? 0 : pdfReverse};
}

/** Sets the source of the next contribution to a shadow ray from `vertex` to a light. `pdf`: density of all
 * light samples together; `otherPdf`: density of the BSDF-sampled ray. */
inline void recordLightSample(PathRecorder& recorder, int vertex, const LiSample& light, float pdf,
                              float otherPdf, float weight) {
  const bool isInfinite = !(light.distance < INFINITE);
  recorder.source = {.technique = PathTechnique::LIGHT_SAMPLE,
                     .vertex = vertex,
                     .step = recorder.source.step,
                     .end = isInfinite ? light.direction : light.target,
                     .isInfinite = isInfinite,
                     .weight = weight,
                     .pdf = light.unhittable ? 0 : pdf,
                     .otherPdf = light.unhittable ? 0 : otherPdf};
}

} // namespace recurse
