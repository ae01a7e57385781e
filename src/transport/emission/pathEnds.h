/** @file
 * Ends of paths at lights and at the camera, with the densities of walks that start there. F denotes the
 * densities of walks from the camera and B those from the lights, as in bidirectionalWeights.h.
 */
#pragma once

#include "recurse/transport/integrator/integrator.h"
#include "transport/direct/lightSampler.h"
#include "transport/emission/emissionMixture.h"
#include "transport/paths/pathVertex.h"
#include "transport/weights/bidirectionalWeights.h"

namespace recurse {

/** x_k: the end of a path at a light. If the path starts in an emissive medium, no member is set. */
struct LightEnd {
  const Light* light = nullptr; ///< null: a medium; the functions below need a light
  uint32_t index = 0;           ///< index in the table of lights
  LeRay ray;                    ///< emitted ray
  double pdf = 0;               ///< B_k; a delta counts as 1
  double pdfNext = 0;           ///< B_k-1 [1/area]

  bool isInfinite() const { return light->isInfinite(); }
  /** Whether rays can hit the light. */
  bool isIntersectable() const { return light->isIntersectable(); }
  LightGeometry geometry() const;
};

/** End of a path that reaches `next` from the light along the ray, with the densities of light paths that
 * start as `emission` says. */
LightEnd lightEnd(const Scene& scene, const EmissionSettings& emission, uint32_t index, const LeRay& ray,
                  const SurfacePoint& next);

/** Factor from a density of directions at `from` to the density of the end: 1 unless it is an area light. */
double directionToEnd(const LightEnd& end, const Vec3f& from);

/** Origin x_j of the shadow ray that samples a path's light, straight through thin panes if there are any. */
struct ShadowRayStart {
  const SurfacePoint* point = nullptr;     ///< x_j; null: no shadow ray finds the light
  Vec3f towardsCamera{0};                  ///< unit
  size_t panes = 0;                        ///< thin panes between x_j and the light x_k: k - 1 - j
  const SurfacePoint* firstPane = nullptr; ///< x_j+1 if there are panes
  const SurfacePoint* lastPane = nullptr;  ///< x_k-1 if there are panes
};

/** WeightedPath::shadowRays of a path with the vertices x_0 … x_k; also 0 if the density of its direction
 * through the panes underflows. */
double shadowRayDensity(const Scene& scene, const LightSampler& lights, const ShadowRayStart& from,
                        const LightEnd& end, std::span<const WeightedVertex> vertices);

/** Target of a visibility test from a vertex, in the form of a light sample. */
inline LiSample visibilityTarget(const Vec3f& position, const Vec3f& direction, float distance) {
  LiSample target;
  target.target = position;
  target.direction = direction;
  target.distance = distance;
  return target;
}

/** x_0: the end of a path at the camera, with the camera ray as its first edge. */
struct CameraEnd {
  double pdf = 1; ///< density of the rays of one pixel [1/sr]; of parallel rays by position [1/area]
  bool parallel = false;
  bool connectable = false; ///< light paths may be connected to the camera along this ray

  CameraEnd(const Scene& scene, const CameraRay& ray);
  CameraEnd(const Scene& scene, const Ray& ray);
  /** Width of a pixel at a distance [scene units]. */
  double footprint(double distance) const { return (parallel ? 1 : distance) / std::sqrt(pdf); }
  /** F_1 of a point that the ray hits [1/area]. */
  double pdfAt(const Vec3f& origin, const SurfacePoint& point, const Vec3f& direction) const {
    return pdf * (parallel ? double(absDot(direction, point.geometricNormal))
                           : areaPerSolidAngle(origin, point, direction));
  }
};

} // namespace recurse
