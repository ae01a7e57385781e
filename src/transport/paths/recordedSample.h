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

/** Sets the source of the next contribution to the emission of a medium along a ray of unit direction that
 * left by `step`, up to the surface at distance `t`, which may be infinite. */
inline void recordFlight(PathRecorder& recorder, int step, const Ray& ray, float t) {
  const bool isInfinite = !(t < INFINITE);
  recorder.source = {.technique = PathTechnique::FLIGHT,
                     .vertex = recorder.source.vertex,
                     .step = step,
                     .end = isInfinite ? ray.direction : ray.at(t),
                     .isInfinite = isInfinite};
}

/** Sets the source of the next contribution to a shadow ray from `vertex` to a light. `pdf`: density of all
 * light samples together; `vertexPdf`: density of the BSDF-sampled ray; `vertexPdfReverse`: see
 * RecordedSource. */
inline void recordLightSample(PathRecorder& recorder, int vertex, const LiSample& light, float pdf,
                              float vertexPdf, float vertexPdfReverse, float weight) {
  const bool isInfinite = !(light.distance < INFINITE);
  recorder.source = {.technique = PathTechnique::LIGHT_SAMPLE,
                     .vertex = vertex,
                     .step = recorder.source.step,
                     .end = isInfinite ? light.direction : light.target,
                     .isInfinite = isInfinite,
                     .weight = weight,
                     .pdf = light.unhittable ? 0 : pdf,
                     .otherPdf = light.unhittable ? 0 : vertexPdf,
                     .vertexPdf = vertexPdf,
                     .vertexPdfReverse = vertexPdfReverse};
}

} // namespace recurse
