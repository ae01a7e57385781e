/** @file
 * A camera path of the photon mapping estimator, and what it shares with photons.
 */
#pragma once

#include <cmath>

#include "transport/direct/directLight.h"
#include "transport/paths/walk.h"
#include "transport/weights/mergeWeights.h"

namespace recurse {

/** Light that comes straight to a surface is shared with photons that are merged at the surface before. */
struct PhotonShare {
  float merged = 0; ///< the part of it that the weights of mergeWeights.h apply to
  MergeRatio ratio; ///< up to the surface
  float rest = 1;   ///< the camera's part where no weight is known

  /** The camera's part; `pdf`: of photons that the surface sends back along the path [1/sr]. */
  float camera(float arrivals, float pdf) const {
    if (merged == 0 || !std::isfinite(arrivals)) return rest;
    return 1 - merged + merged * ratio.cameraWeight(arrivals, pdf);
  }
};

/** A ray that may meet such light. */
struct SharedRay {
  PhotonShare share;
  Rgb throughput{0}; ///< without the share
  float pdf = 0;     ///< see PhotonShare::camera
  float cosine = 0;  ///< at the surface
};

/** A camera path on its way. */
struct PathState {
  CameraRay ray;
  CameraState camera;
  Nesting nesting;
  Rgb throughput{1};
  float part = 1;       ///< of what it finds that photons on the way have left to it
  float etaScale = 1;   ///< undoes the 1/η² inside glass
  float mediaScale = 1; ///< undoes what media have absorbed and scattered away, no reason to prune a branch
  int depth = 0;        ///< scattering events so far
  int nonDelta = 0;     ///< those by non-delta lobes
  float wavelength = 0; ///< as in Subpath
  // Since the last of these:
  float distance = 0;             ///< travelled [scene units]
  bool delta = false;             ///< by mirrors and glass, thin panes apart
  bool panes = false;             ///< through thin panes, where shadow rays go too
  bool byRays = true;             ///< no photons are kept there: it is the camera, or on a curve
  float share = 1;                ///< of the indirect light there that is for this path to find
  PhotonShare direct;             ///< the same of the direct light there
  SharedRay shared;               ///< of light that is met at once
  BsdfRay bsdfRay;                ///< weighs light that is met at once against shadow rays
  MergeRatio merge;               ///< weighs light that is met by mirrors and glass against caustic photons
  float lightShare = 1;           ///< of emission that is met, where photons bring all light
  int recordedStep = CAMERA_STEP; ///< by which the ray left, see PathRecorder
  int recordedVertex = NOT_RECORDED; ///< the last one

  /** The throughput of light that photons on the way bring as well. */
  Rgb sharedThroughput() const { return throughput * part; }

  /** The path after a scattering event; `pane`: it went straight through a thin pane. */
  PathState after(const Hit& hit, const Scatter& s, bool pane = false) const {
    PathState next = *this;
    next.nesting.scatters(hit, -ray.direction, s.direction);
    next.throughput *= s.weight;
    next.throughput *= dispersedColour(hit.point, s, next.wavelength);
    next.etaScale *= square(s.eta);
    static_cast<Ray&>(next.ray) = spawn(hit.point, s.direction);
    if (s.specular()) {
      (pane ? next.panes : next.delta) = true;
      next.merge.leave(s.direction, hit.point);
    }
    return next;
  }
};

} // namespace recurse
