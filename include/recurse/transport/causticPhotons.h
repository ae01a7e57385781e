/** @file
 * Photons of caustics alone beside a path tracer, whose rays hardly find such light: a lamp behind glass is
 * met by chance only. Photons and rays that find the same paths are weighed by mergeWeights.h.
 */
#pragma once

#include "recurse/transport/photonPass.h"

namespace recurse {

class CausticPhotons {
 public:
  explicit CausticPhotons(PhotonPassSettings settings) : photons(onlyCaustics(settings)) {}

  /** See PhotonPass. */
  ForwardStatistics run(const Scene& scene, const PathClasses& classes, const Pass& pass,
                        const ForwardControl& control, const LightSampler& shadowRays) {
    return photons.run(scene, classes, pass, control, shadowRays);
  }
  ForwardStatistics with(const Pass& other, const Scene& scene, const PathClasses& classes,
                         const ForwardControl& control, const LightSampler& shadowRays,
                         const std::function<void()>& use) {
    return photons.with(other, scene, classes, control, shadowRays, use);
  }
  const PhotonPass& pass() const { return photons; }

  /** Adds the caustics at a vertex with non-delta lobes, seen from unit `wi` with `throughput`; `camera` has
   * read the D there, `width` is that of a pixel. Returns the photons' weight against the ray that goes on,
   * see MergeRatio. */
  float add(const Scene& scene, const SurfacePoint& point, const Vec3f& wi, const ScatteringPoint& scattering,
            const Rgb& throughput, CameraState camera, float width, const Sampler& sampler,
            PathRadiance& out) const;

 private:
  static PhotonPassSettings onlyCaustics(PhotonPassSettings settings) {
    settings.causticsOnly = true;
    settings.directLight = false;
    return settings;
  }
  PhotonPass photons;
};

/** A camera ray's side of these weights, along a path of a path tracer. */
class CausticRay {
 public:
  /** At a vertex with non-delta lobes; `merging`: what CausticPhotons::add() returned, 0 in media. */
  void leaveNonDelta(float merging, float pdf, const Vec3f& direction, const SurfacePoint& from) {
    merge = merging > 0 ? MergeRatio(merging, pdf, direction, from) : MergeRatio();
  }
  void leaveDelta(const Vec3f& arrived, const Vec3f& left, const SurfacePoint& at) {
    merge.arrive(arrived, at);
    merge.leave(left, at);
  }
  const MergeRatio& ratio() const { return merge; }

 private:
  MergeRatio merge;
};

} // namespace recurse
