/** @file
 * Photon record: the result of photon tracing and the input of the photon map; at most 40 bytes.
 */
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "recurse/core/math/rgb.h"
#include "recurse/core/math/vector.h"
#include "recurse/model/shape/shape.h"

namespace recurse {

/**
 * Unit direction in 32 bits: octahedral map (Meyer et al. 2010, "On Floating-Point Normal Vectors") with 16
 * bits for each axis. The error is below 4e-5 rad.
 */
struct PackedDirection {
  uint32_t bits = 0;
};

inline PackedDirection packDirection(const Vec3f& d) {
  const float norm = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
  float u = d.x / norm, v = d.y / norm;
  if (d.z < 0) {
    const float fu = (1 - std::abs(v)) * std::copysign(1.0f, u);
    v = (1 - std::abs(u)) * std::copysign(1.0f, v);
    u = fu;
  }
  const auto quantise = [](float x) {
    return static_cast<uint32_t>(std::lround((std::clamp(x, -1.0f, 1.0f) + 1) * 32767.0f));
  };
  return {quantise(u) | (quantise(v) << 16)};
}

inline Vec3f unpackDirection(PackedDirection p) {
  const float u = static_cast<float>(p.bits & 0xffffu) * (1 / 32767.0f) - 1;
  const float v = static_cast<float>(p.bits >> 16) * (1 / 32767.0f) - 1;
  const float z = 1 - std::abs(u) - std::abs(v);
  const float fold = std::max(-z, 0.0f);
  return glm::normalize(Vec3f(u - std::copysign(fold, u), v - std::copysign(fold, v), z));
}

/** Photon stored at a surface. */
struct Photon {
  Vec3f position;            ///< scene units, relative to the scene's centre
  PackedDirection direction; ///< unit, from the surface back along the photon's path
  Rgb power;                 ///< flux [W]
  uint8_t pathState = 0;     ///< LightState after the events before this surface
  bool caustic = false;      ///< only specular events, or none, between the light and this surface
  PackedDirection normal;    ///< geometric, unit, on the side that the photon came from
  /** Ratio of densities, camera ray to photon, see mergeWeights.h; 0 if no camera ray finds the path, or it
   * is unknown. Negative after several non-delta surfaces: such photons are not weighted by it. */
  float reverseRatio = 0;
};
static_assert(sizeof(Photon) <= 40);

/** Packs a direction without a change of side: rounding could hide a grazing photon from all queries. */
inline PackedDirection packOnSide(const Vec3f& wi, const Vec3f& normal) {
  PackedDirection packed = packDirection(wi);
  const float cosine = glm::dot(wi, normal);
  if (std::abs(cosine) > 1e-4f) return packed; // larger than the packing error
  const Vec3f up = normal * std::copysign(1.0f, cosine);
  for (float lift = 4e-5f; glm::dot(unpackDirection(packed), up) < 1e-6f; lift *= 2)
    packed = packDirection(glm::normalize(wi + up * lift));
  return packed;
}

/** Photon that arrives from unit `wi` at a surface; nullopt where it is parallel to the surface: no flux. Its
 * power is divided by alpha, so that the map has the flux on the whole surface, though a part of the photons
 * passes it: camera rays that query the map hit the surface with probability alpha, too. */
inline std::optional<Photon> photonAt(const SurfacePoint& point, const Vec3f& wi, const Rgb& power,
                                      uint8_t pathState) {
  const Vec3f& normal = point.geometricNormal;
  const float cosine = glm::dot(wi, normal);
  if (cosine == 0) return {};
  Photon photon;
  photon.position = point.position;
  photon.direction = packOnSide(wi, normal);
  photon.normal = packDirection(cosine < 0 ? -normal : normal);
  photon.power = power / point.alpha;
  photon.pathState = pathState;
  return photon;
}

} // namespace recurse
