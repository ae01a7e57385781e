/** @file
 * The ends of paths at lights and at the camera, with the densities of walks that start there; F is of walks
 * from the camera and B of walks from the lights, as in bidirectionalWeights.h.
 */
#pragma once

#include "recurse/transport/integrator/integrator.h"
#include "transport/direct/lightSampler.h"
#include "transport/emission/emissionGuide.h"
#include "transport/paths/pathVertex.h"
#include "transport/weights/bidirectionalWeights.h"

namespace recurse {

/** x_k: the end of a path at a light. */
struct LightEnd {
  const Light* light = nullptr;
  uint32_t index = 0; ///< in the table of lights
  LeRay ray;          ///< that leaves it
  double pdf = 0;     ///< B_k; a delta counts as 1
  double pdfNext = 0; ///< B_k-1 [1/area]

  bool isInfinite() const;
  /** Whether rays may meet it. */
  bool isIntersectable() const;
  LightGeometry geometry() const;
};

/** The end of a path that reaches `next` from the light along the ray. */
LightEnd lightEnd(const Scene& scene, uint32_t index, const LeRay& ray, const SurfacePoint& next);

/** What makes a density of directions at `from` one of the light's end: 1 where that is infinitely far. */
double directionToEnd(const LightEnd& end, const Vec3f& from);

/** Density with which a shadow ray from x_k-1 chooses the end, in the measure of B_k. */
double shadowRayPdf(const Scene& scene, const LightSampler& lights, const LightSampleContext& from,
                    const LightEnd& end);

/** Of a path: x_j, where the shadow ray starts that finds its light, straight through thin panes if any. */
struct ShadowRayStart {
  const SurfacePoint* point = nullptr;     ///< x_j; null: no shadow ray finds the light
  Vec3f towardsCamera{0};                  ///< unit
  size_t panes = 0;                        ///< k - 1 - j
  const SurfacePoint* firstPane = nullptr; ///< x_j+1, where there are any
  const SurfacePoint* lastPane = nullptr;  ///< x_k-1
};

/** WeightedPath::shadowRays of a path with these vertices x_0 … x_k; 0 too where the density of its way
 * through panes is too small for its number. */
double shadowRayDensity(const Scene& scene, const LightSampler& lights, const ShadowRayStart& from,
                        const LightEnd& end, std::span<const WeightedVertex> vertices);

/** Samples a light path's start by numbers of the sampler. Empty: nothing is emitted. The end's pdfNext is
 * not set: it is that of the first vertex. A `guide` changes the flux, and the densities do not know of it.
 */
struct LightStart {
  LightSubpath path;
  LightEnd end;
};
std::optional<LightStart> startLightSubpath(const Scene& scene, const PathClasses& classes, float time,
                                            Sampler& sampler, TransportCounts& counts,
                                            const EmissionGuide& guide = {});

/** A point that is to be seen from a vertex, as a light would be. */
inline LiSample visibilityTarget(const Vec3f& position, const Vec3f& direction, float distance) {
  LiSample target;
  target.target = position;
  target.direction = direction;
  target.distance = distance;
  return target;
}

/** x_0: a ray of the camera, as the first edge of paths. */
struct CameraEnd {
  double pdf = 1; ///< of rays of one pixel by direction [1/sr], or where they are parallel by place [1/area]
  bool parallel = false;
  bool connectable = false; ///< light paths may be connected to the camera along this ray

  CameraEnd(const Scene& scene, const CameraRay& ray);
  CameraEnd(const Scene& scene, const Ray& ray);
  /** Width of a pixel at a distance. */
  double footprint(double distance) const { return (parallel ? 1 : distance) / std::sqrt(pdf); }
  /** F_1 of a point that the ray meets. */
  double pdfAt(const Vec3f& origin, const SurfacePoint& point, const Vec3f& direction) const {
    return pdf * (parallel ? double(absDot(direction, point.geometricNormal))
                           : areaPerSolidAngle(origin, point, direction));
  }
};

} // namespace recurse
