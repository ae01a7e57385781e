/** @file
 * Caustics by photons in a path tracer, whose rays rarely find them: they hit a lamp behind glass by chance
 * only. Both estimators share the same paths by the MIS weights of mergeWeights.h.
 */
#pragma once

#include "recurse/transport/integrator/integrator.h"
#include "transport/paths/opticalPath.h"
#include "transport/weights/mergeWeights.h"

namespace recurse {

/** Interface of caustic photon maps for a path tracer. */
class CausticPhotons {
 public:
  virtual ~CausticPhotons() = default;
  /** Adds the caustics at a vertex with non-delta lobes, seen from unit `wi` with `throughput`; `camera`:
   * state after its D event; `width`: pixel footprint [scene units]; `optical`: on arrival. Returns the
   * merge density of the photons for the ray that continues, see MergeRatio. */
  virtual float add(const Scene& scene, const SurfacePoint& point, const Vec3f& wi,
                    const ScatteringPoint& scattering, const Rgb& throughput, CameraState camera, float width,
                    const OpticalPath& optical, const Sampler& sampler, PathRadiance& out) const = 0;
  /** MIS weight of a ray that hits an area light by way of mirrors and glass. */
  virtual float rayWeight(const Scene& scene, const MergeRatio& merge, const Hit& hit,
                          const Ray& ray) const = 0;
  /** MIS weight of a ray that leaves the scene, for one of its environment lights. */
  virtual float rayWeight(const Scene& scene, const MergeRatio& merge, size_t environment,
                          const Ray& ray) const = 0;
};

/** Camera's side of these MIS weights along a path. */
class CausticRay {
 public:
  /** Leaves a non-delta vertex; `mergeDensity`: result of CausticPhotons::add(), 0 in media. */
  void leaveNonDelta(float mergeDensity, float pdf, const Vec3f& direction, const SurfacePoint& from) {
    merge = mergeDensity > 0 ? MergeRatio(mergeDensity, pdf, direction, from) : MergeRatio();
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
