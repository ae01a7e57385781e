/** @file
 * Ellipsoids as affine images of the unit sphere, in double precision.
 */
#pragma once

#include "recurse/model/shape/shape.h"

namespace recurse {

/** Intersections of a line with the unit sphere, the nearer one first. */
inline bool intersectUnitSphere(const Vec3d& o, const Vec3d& d, double (&t)[2]) {
  const double a = glm::dot(d, d), b = glm::dot(o, d), c = glm::dot(o, o) - 1;
  if (!(a > 0)) return false;
  // Discriminant from the point of the ray nearest to the centre, which keeps its precision when the sphere
  // is small and far (Haines et al., "Precision Improvements for Ray/Sphere Intersection", 2019).
  const Vec3d nearest = o - d * (b / a);
  double discriminant = 1 - glm::dot(nearest, nearest);
  if (c < 0) discriminant = std::max(discriminant, 0.0);
  if (!(discriminant >= 0)) return false;
  const double root = std::sqrt(discriminant * a);
  const double q = b < 0 ? root - b : -b - root;
  t[0] = q / a;
  t[1] = q != 0 ? c / q : 0;
  if (t[0] > t[1]) std::swap(t[0], t[1]);
  return true;
}

/** Angle around the z axis in [0, 2π). */
inline double azimuth(const Vec3d& d) {
  const double phi = std::atan2(d.y, d.x);
  return phi < 0 ? phi + 2 * PI_D : phi;
}

/** Coordinates of pbrt on a part of the unit sphere: around in u, from the lower end up in v [rad]. */
struct SphereAngles {
  double phiMax = 2 * PI_D, thetaLow = PI_D, thetaHigh = 0; ///< polar angles from the z axis

  Vec3d pointAt(double u, double v) const {
    const double theta = thetaLow + (thetaHigh - thetaLow) * v, phi = phiMax * u;
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
  }
};

/** Linear map of the unit sphere, to be scaled and moved. */
struct EllipsoidMap {
  Mat3d linear, inverse;
  Mat3d magnitude{1};      ///< absolute values of the former
  double determinant;      ///< absolute
  double side;             ///< -1 where the inside counts as outside
  double unitError;        ///< bound on the rounding error of a point taken to the unit sphere
  double uniformScale = 0; ///< 0 for ellipsoids

  EllipsoidMap(const Mat3d& linear, bool reverseOrientation)
      : linear(linear), inverse(glm::inverse(linear)), determinant(std::abs(glm::determinant(linear))),
        side(reverseOrientation ? -1 : 1) {
    Mat3d inverseMagnitude;
    for (int i = 0; i < 3; ++i) {
      magnitude[i] = glm::abs(linear[i]);
      inverseMagnitude[i] = glm::abs(inverse[i]);
    }
    // Bound on the double-precision rounding error of a transform to the unit sphere and back.
    const Vec3d there = inverseMagnitude * (magnitude * Vec3d(1));
    unitError = 0x1p-50 * std::max(there.x, std::max(there.y, there.z));
    // Tests for a rotation with uniform scale, up to the rounding of numbers in the file.
    const Mat3d gram = glm::transpose(linear) * linear;
    uniformScale = std::cbrt(determinant);
    const double r2 = square(uniformScale);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        if (!(std::abs(gram[i][k] - (i == k ? r2 : 0)) <= 1e-9 * r2)) uniformScale = 0;
  }

  /** Half of the size along the axes of the scene. */
  Vec3d extent() const {
    Vec3d e;
    for (int i = 0; i < 3; ++i)
      e[i] = std::sqrt(square(linear[0][i]) + square(linear[1][i]) + square(linear[2][i]));
    return e;
  }

  /** Position, error and normal of the image of a unit vector on the ellipsoid around `center`, `scale`
   * times as large as the map's. */
  SurfacePoint placeAt(const Vec3d& center, double scale, const Vec3d& unit) const {
    SurfacePoint s;
    const Vec3d position = center + linear * unit * scale;
    const Vec3d gradient = glm::transpose(inverse) * unit;
    const double steepness = glm::length(gradient);
    const Vec3d normal = gradient * (side / steepness);
    s.position = Vec3f(position);
    s.geometricNormal = s.shadingNormal = Vec3f(normal);
    const Vec3d exactError = 0x1p-50 * (magnitude * glm::abs(unit) * scale + glm::abs(center));
    s.error = positionError(position, exactError, normal, unitError * scale / steepness);
    return s;
  }

  SurfacePoint pointAt(const Vec3d& center, double scale, const Vec3d& unit,
                       const SphereAngles& angles) const {
    SurfacePoint s = placeAt(center, scale, unit);
    const double rho = std::sqrt(square(unit.x) + square(unit.y)), theta = std::atan2(rho, unit.z);
    const double rise = angles.thetaHigh - angles.thetaLow;
    s.uv = {static_cast<float>(std::min(azimuth(unit) / angles.phiMax, 1.0)),
            static_cast<float>(std::clamp((theta - angles.thetaLow) / rise, 0.0, 1.0))};
    const Vec2d outwards = rho > 0 ? Vec2d(unit) / rho : Vec2d(1, 0);
    const Vec3d dpdu = Vec3d(-unit.y, unit.x, 0) * angles.phiMax,
                dpdv = Vec3d(outwards * unit.z, -rho) * rise;
    s.dpdu = Vec3f(linear * dpdu * scale);
    s.dpdv = Vec3f(linear * dpdv * scale);
    // The unit sphere's normal is its position.
    const Vec3d gradient = glm::transpose(inverse) * unit;
    s.dndu = derivativeOfUnit(gradient, glm::transpose(inverse) * dpdu, side);
    s.dndv = derivativeOfUnit(gradient, glm::transpose(inverse) * dpdv, side);
    return s;
  }

  /** Factor by which the map stretches the unit sphere's area at the point with this normal in the scene. */
  double stretch(const Vec3d& normal) const {
    return determinant / glm::length(glm::transpose(linear) * normal);
  }
};

} // namespace recurse
