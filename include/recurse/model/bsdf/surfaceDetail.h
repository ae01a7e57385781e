/** @file
 * Bumps and normal maps of materials: they change the shading normal and nothing else.
 */
#pragma once

#include <memory>

#include "recurse/core/io/fileReference.h"
#include "recurse/model/texture/texture.h"

namespace recurse {

/** Changes the shading frame of a point before its BSDF is made. */
class SurfaceDetail {
 public:
  virtual ~SurfaceDetail() = default;
  virtual void apply(SurfacePoint& point) const = 0;
};

/**
 * The shading normal of the surface raised by `height` [scene units] along its normal (Blinn, "Simulation of
 * Wrinkled Surfaces", 1978): that of the derivatives dpdu + (dh/du) n + h dndu, and the same by v, as in
 * pbrt-v4.
 */
std::unique_ptr<SurfaceDetail> bumps(const TexturedRgb& height);
/** The normal by a picture: 2 (r, g, b) - 1 along dpdu, across it, and along the shading normal. Throws
 * Error. */
std::unique_ptr<SurfaceDetail> normalMap(const FileReference& file);

} // namespace recurse
