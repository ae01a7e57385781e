/** @file
 * Camera path of the photon mapping estimator, and its weights against photons.
 */
#pragma once

#include "recurse/transport/integrator/lightPathRecorder.h"
#include "transport/direct/directLight.h"
#include "transport/paths/walker.h"
#include "transport/weights/mergeWeights.h"

namespace recurse {

/** MIS weights of the light that a ray finds, from the last non-delta vertex or the camera on. */
struct RayWeights {
  bool byRays = true;   ///< no photons are stored at that vertex: the camera, or a point on a curve
  float share = 1;      ///< weight of light scattered by media and at the next non-delta vertex
  BsdfRay bsdfRay;      ///< directly hit light against shadow rays
  MergeRatio merge;     ///< light hit through mirrors and glass, against photons
  float lightShare = 1; ///< weight of hit emission where photons carry all light
};

/** Camera path: the walk, and its weights against photons. */
struct PathState {
  CameraSubpath walk;
  float remainingWeight = 1; ///< remaining MIS weight after photons at earlier vertices
  float mediaScale = 1;      ///< cancels the attenuation by media, which must not prune a branch
  int nonDelta = 0;          ///< number of scattering events by non-delta lobes
  float distance = 0;        ///< length since the last of these, or since the camera [scene units]
  bool delta = false;        ///< since then through mirrors and glass, thin panes excluded
  bool panes = false;        ///< since then through thin panes, which shadow rays pass as well
  RayWeights weights;
  int recordedStep = CAMERA_STEP;    ///< step by which the ray left, see PathRecorder
  int recordedVertex = NOT_RECORDED; ///< last recorded vertex

  /** Throughput times the weight that photons at earlier vertices leave to the path. */
  Rgb sharedThroughput() const { return walk.throughput * remainingWeight; }

  /** Path after a scattering event by a delta lobe; `pane`: it went straight through a thin pane. */
  PathState afterDelta(const CameraWalker& walker, const CameraVertex& vertex, const Scatter& s,
                       bool pane) const {
    PathState next = *this;
    walker.follow(next.walk, vertex, s);
    (pane ? next.panes : next.delta) = true;
    next.weights.merge.leave(s.direction, vertex.point());
    return next;
  }
  /** Path after a scattering event by a non-delta lobe. Its RayWeights are not set. */
  PathState afterNonDelta(const CameraWalker& walker, const CameraVertex& vertex, const Scatter& s) const {
    PathState next = *this;
    walker.follow(next.walk, vertex, s);
    ++next.nonDelta;
    next.distance = 0;
    next.delta = next.panes = false;
    return next;
  }
};

} // namespace recurse
