/** @file
 * What every shape and every material can be given besides its own parameters: opacity, and bumps that change
 * the shading normal and nothing else.
 */
#pragma once

#include <memory>

#include "recurse/core/fileReference.h"
#include "recurse/model/texture.h"

namespace recurse {

struct PlugIns;

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

/** Gives every shape `alpha`, and every material `displacement` and `normalmap`. */
void addSurfaceParameters(PlugIns& plugIns);

} // namespace recurse
