/** @file
 * Recording of the vertices that a Walker finds from the camera.
 */
#pragma once

#include "recurse/transport/integrator/pathRecorder.h"
#include "transport/paths/pathVertex.h"

namespace recurse {

/** Camera path of a Walker in a PathRecorder. Copies record branches of the path. Does nothing without a
 * recorder. */
class RecordedCameraPath {
 public:
  explicit RecordedCameraPath(PathRecorder* recorder) : recorder(recorder) {}

  /** Adds a vertex; light samples and merges that follow belong to it. */
  void arrive(const CameraVertex& vertex) {
    if (recorder) [[unlikely]]
      addVertex(vertex);
  }
  /** Adds the step from the latest vertex. `throughput`: after the event. */
  void leave(const CameraVertex& vertex, const Scatter& s, const Rgb& throughput) {
    if (recorder) [[unlikely]]
      addStep(vertex, s, throughput);
  }

  int vertex() const { return lastVertex; }
  int step() const { return lastStep; }

 private:
  void addVertex(const CameraVertex& vertex);
  void addStep(const CameraVertex& vertex, const Scatter& s, const Rgb& throughput);

  PathRecorder* recorder;
  int lastVertex = NOT_RECORDED, lastStep = CAMERA_STEP;
};

} // namespace recurse
