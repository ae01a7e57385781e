/** @file
 * Caustics by another estimator beside a path tracer, whose rays hardly find them: a lamp behind glass is met
 * by chance only. Both find the same paths and share them by the weights of mergeWeights.h.
 */
#pragma once

#include "recurse/transport/integrator/integrator.h"
#include "transport/weights/mergeWeights.h"

namespace recurse {

/** Photons of caustics, as a path tracer uses them. */
class CausticPhotons {
 public:
  virtual ~CausticPhotons() = default;
  /** Adds the caustics at a vertex with non-delta lobes, seen from unit `wi` with `throughput`; `camera` has
   * read the D there, `width` is that of a pixel. Returns the photons' weight against the ray that goes on,
   * see MergeRatio. */
  virtual float add(const Scene& scene, const SurfacePoint& point, const Vec3f& wi,
                    const ScatteringPoint& scattering, const Rgb& throughput, CameraState camera, float width,
                    const Sampler& sampler, PathRadiance& out) const = 0;
  /** The weight of a ray that hits an area light behind mirrors and glass. */
  virtual float rayWeight(const Scene& scene, const MergeRatio& merge, const Hit& hit,
                          const Vec3f& direction) const = 0;
  /** The same for a ray that leaves the scene, and one of its environment lights. */
  virtual float rayWeight(const Scene& scene, const MergeRatio& merge, size_t environment,
                          const Ray& ray) const = 0;
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
