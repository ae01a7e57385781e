/** @file
 * Fresnel reflectance of smooth interfaces for unpolarised light (Born, Wolf, "Principles of Optics", 1.5.2
 * and 14.2).
 */
#pragma once

#include "recurse/core/math/rgb.h"

namespace recurse {

/** Reflection and refraction of a ray at a smooth dielectric interface. */
struct DielectricFresnel {
  float reflectance = 1;    ///< reflectance in [0, 1]; 1 at total reflection
  float cosTransmitted = 0; ///< cosine of the refracted ray with the normal, >= 0
};

/** `cosIncident` in [0, 1]; eta: refractive index beyond over the index on the incident side, > 0. */
inline DielectricFresnel dielectricFresnel(float cosIncident, float eta) {
  if (eta == 1) return {0, cosIncident};
  // 1 - sin²/eta², written so that it is exact where eta is near 1.
  const float cos2 = square(cosIncident);
  const float cosT2 = (cos2 + (eta - 1) * (eta + 1)) / square(eta);
  if (cosT2 <= 0) return {1, 0};
  const float cosT = std::sqrt(cosT2);
  const float parallel = (eta * cosIncident - cosT) / (eta * cosIncident + cosT);
  const float perpendicular = (cosIncident - eta * cosT) / (cosIncident + eta * cosT);
  return {0.5f * (square(parallel) + square(perpendicular)), cosT};
}

/** Reflectance of a conductor of complex index eta + i k, for one channel. */
inline float conductorFresnel(float cosIncident, float eta, float k) {
  const double c = cosIncident, c2 = c * c, s2 = 1 - c2;
  const double eta2 = double(eta) * double(eta), k2 = double(k) * double(k);
  const double t0 = eta2 - k2 - s2;
  const double a2b2 = std::sqrt(t0 * t0 + 4 * eta2 * k2);
  const double a = std::sqrt(std::max(0.0, 0.5 * (a2b2 + t0)));
  if (a2b2 + c2 == 0) return 0; // along an interface of equal indices, which is none
  const double perpendicular = std::max(0.0, a2b2 + c2 - 2 * c * a) / (a2b2 + c2 + 2 * c * a);
  const double t3 = c2 * a2b2 + s2 * s2, t4 = 2 * c * a * s2;
  const double parallel = t3 + t4 > 0 ? perpendicular * std::max(0.0, t3 - t4) / (t3 + t4) : perpendicular;
  return static_cast<float>(0.5 * (parallel + perpendicular));
}

} // namespace recurse
