/** @file
 * Optical length of paths, for transient renders: geometric length times the refractive index on the way.
 */
#pragma once

#include "recurse/model/bsdf/scatteringPoint.h"
#include "recurse/model/scene/scene.h"

namespace recurse {

/** Optical length of a subpath from its light or camera, and the refractive index where it is. */
struct OpticalPath {
  float length = 0; ///< [scene units]
  float index = 1;

  void travel(float distance) { length += index * distance; }
  /** Changes the index at a scattering event, by Scatter::eta. */
  void scatter(float eta) { index *= eta; }
  /** Length of the path at a distance further on [scene units]. */
  float at(float distance) const { return length + index * distance; }
};

/** Length of light from infinitely far to a point, seen in unit direction `toLight`: its wave front starts at
 * the plane that touches the scene's bounding sphere [scene units]. */
inline float lengthFromInfinity(const Scene& scene, const Vec3f& point, const Vec3f& toLight) {
  return scene.bounds().radius - glm::dot(point - scene.bounds().center, toLight);
}

/** Distance that light travels from a light sample to a point [scene units]. */
inline float distanceToLight(const Scene& scene, const Vec3f& point, const LiSample& light) {
  return light.distance < INFINITE ? light.distance : lengthFromInfinity(scene, point, light.direction);
}

/** Optical path that arrives at a surface from unit `wi`, as it leaves towards unit `wo`. */
inline OpticalPath leaving(OpticalPath path, const ScatteringPoint& scattering, const Vec3f& wi,
                           const Vec3f& wo) {
  path.scatter(scattering.relativeIndex(wi, wo));
  return path;
}

/** Length at a point of light that a photon carries to another point near by, of a path of length `photon`
 * that arrived from unit `wi`: its wave front is taken as plane, in a medium of refractive index `index`. */
inline float lengthNear(const Vec3f& point, const Vec3f& photonPosition, const Vec3f& wi, float photon,
                        float index) {
  return photon - index * glm::dot(point - photonPosition, wi);
}

} // namespace recurse
