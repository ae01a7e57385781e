/** @file
 * Bump and normal maps of materials, which change the shading normal and nothing else.
 */
#pragma once

#include <memory>

#include "recurse/core/io/fileReference.h"
#include "recurse/model/texture/texture.h"

namespace recurse {

/** Modifies the shading normal of a point before its BSDF is made. */
class SurfaceDetail {
 public:
  virtual ~SurfaceDetail() = default;
  /** Replaces the shading normal, which stays unit and in the hemisphere of the geometric normal. May use the
   * footprint. Any thread may call it. */
  virtual void apply(SurfacePoint& point) const = 0;
};

/**
 * Bump map: shading normal of the surface displaced along its normal by the red component of `height` [scene
 * units] (Blinn, "Simulation of Wrinkled Surfaces", 1978), from the derivatives dpdu + (dh/du) n + h dndu,
 * and likewise by v, as in pbrt-v4.
 */
std::unique_ptr<SurfaceDetail> bumps(const TexturedRgb& height);
/** Normal map: the normal is 2 (r, g, b) - 1 in the frame x, n × x, n, with n the shading normal and x along
 * dpdu; colours are not decoded from sRGB. Throws Error where the file cannot be read. */
std::unique_ptr<SurfaceDetail> normalMap(const FileReference& file);

} // namespace recurse
