/** @file
 * Camera path of the photon mapping estimator, and its weights against photons.
 */
#pragma once

#include <cmath>

#include "recurse/transport/integrator/lightPathRecorder.h"
#include "transport/direct/directLight.h"
#include "transport/paths/walker.h"
#include "transport/weights/mergeWeights.h"

namespace recurse {

/** Weights of light straight to a surface, shared with photons that are merged at the previous surface. */
struct PhotonShare {
  float merged = 0;        ///< fraction of the light that the weights of mergeWeights.h apply to
  MergeRatio ratio;        ///< merge ratio up to the surface
  float unknownWeight = 1; ///< weight of the camera path where the photons' density is unknown

  /** Weight of the camera path; `pdf`: of photons scattered by the surface back along the path [1/sr]. */
  float camera(float arrivals, float pdf) const {
    if (merged == 0 || !std::isfinite(arrivals)) return unknownWeight;
    return 1 - merged + merged * ratio.cameraWeight(arrivals, pdf);
  }
};

/** Ray that may hit light shared with photons. */
struct SharedRay {
  PhotonShare share;
  float remainingWeight = 0; ///< PathState::remainingWeight without the weight of `share`
  float pdf = 0;             ///< see PhotonShare::camera()
  float cosine = 0;          ///< cosine at the surface that the ray leaves
};

/** MIS weights of the light that a ray finds, from the last non-delta vertex or the camera on. */
struct RayWeights {
  bool byRays = true;   ///< no photons are stored at that vertex: the camera, or a point on a curve
  float share = 1;      ///< weight of light scattered by media and at the next non-delta vertex
  PhotonShare direct;   ///< weights of the direct light at that vertex; its `unknownWeight` becomes `share`
  SharedRay shared;     ///< directly hit light against photons
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
