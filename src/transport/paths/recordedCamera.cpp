/** @file
 * Recording of the vertices that a Walker finds from the camera.
 */
#include "transport/paths/recordedCamera.h"

#include "transport/paths/recordedSample.h"

namespace recurse {

void RecordedCameraPath::addVertex(const CameraVertex& vertex) {
  if (vertex.medium)
    lastVertex = recorder->addVertex({.step = lastStep,
                                      .position = vertex.point().position,
                                      .inMedium = true,
                                      .throughput = vertex.throughput});
  else
    lastVertex =
        recorder->addVertex(lastStep, vertex.hit, -vertex.wi, vertex.scattering->lobes(), vertex.throughput);
}

void RecordedCameraPath::addStep(const CameraVertex& vertex, const Scatter& s, const Rgb& throughput) {
  RecordedStep step =
      recordedStep(lastVertex, s, throughput, static_cast<float>(vertex.pdfReverse(s.direction)));
  if (vertex.medium) step.event = PathEvent::V;
  lastStep = recorder->addStep(step);
}

} // namespace recurse
