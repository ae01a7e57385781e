/** @file
 * Recording of the vertices that a Walker finds from the camera.
 */
#pragma once

#include "recurse/transport/integrator/pathRecorder.h"
#include "transport/paths/pathVertex.h"
#include "transport/paths/recordedSample.h"

namespace recurse {

/** Camera path of a Walker in a PathRecorder. Copies record branches of the path. Does nothing without a
 * recorder. */
class RecordedCameraPath {
 public:
  explicit RecordedCameraPath(PathRecorder* recorder) : recorder(recorder) {}

  /** Adds a vertex; light samples and merges that follow belong to it. */
  void arrive(const CameraVertex& vertex) {
    if (!recorder) [[likely]]
      return;
    if (vertex.medium)
      lastVertex = recorder->addVertex({.step = lastStep,
                                        .position = vertex.point().position,
                                        .inMedium = true,
                                        .throughput = vertex.throughput});
    else
      lastVertex = recorder->addVertex(lastStep, vertex.hit, -vertex.wi, vertex.scattering->lobes(),
                                       vertex.throughput);
  }
  /** Adds the step from the latest vertex. `throughput`: after the event. */
  void leave(const CameraVertex& vertex, const Scatter& s, const Rgb& throughput) {
    if (!recorder) [[likely]]
      return;
    RecordedStep step =
        recordedStep(lastVertex, s, throughput, static_cast<float>(vertex.pdfReverse(s.direction)));
    if (vertex.medium) step.event = PathEvent::V;
    lastStep = recorder->addStep(step);
  }

  int vertex() const { return lastVertex; }
  int step() const { return lastStep; }

 private:
  PathRecorder* recorder;
  int lastVertex = NOT_RECORDED, lastStep = CAMERA_STEP;
};

} // namespace recurse
