/** @file
 * Mappings from surfaces to texture coordinates: two coordinates, or points of texture space, each with its
 * differentials over the footprint of a sample.
 */
#pragma once

#include <vector>

#include "recurse/model/texture/texture.h"

namespace recurse {

/** Texture coordinates and their differentials along the axes of the footprint; zero where unknown. */
struct MappedCoordinates {
  Vec2f st{0}, alongX{0}, alongY{0};
  /** Half the size of the bounding box of the parallelogram of both axes, which contains the footprint. */
  Vec2f extent() const { return 0.5f * (glm::abs(alongX) + glm::abs(alongY)); }
};
/** Point of texture space and its differentials along the axes of the footprint; zero where unknown. */
struct MappedPoint {
  Vec3d p{0};
  Vec3f alongX{0}, alongY{0};
};

/** Axes of the ellipse in which the footprint's cone intersects the surface; zero where unknown. */
struct FootprintAxes {
  explicit FootprintAxes(const SurfacePoint& point);
  Vec3f x{0}, y{0}; ///< full lengths of the axes
};

/** pbrt-v4's `mapping` of two-dimensional textures. */
class TextureMapping {
 public:
  /** Reads the parameters of withMapping(). Throws SceneError for one that the mapping does not use. */
  TextureMapping(const Parameters& parameters, const TextureContext& context);
  MappedCoordinates at(const SurfacePoint& point) const;

 private:
  enum class Kind { UV, SPHERICAL, CYLINDRICAL, PLANAR };
  Vec2d of(const Vec3d& p, Vec3d& ds, Vec3d& dt) const;

  Kind kind = Kind::UV;
  Vec2d scale{1}, delta{0};
  Vec3d axisS{1, 0, 0}, axisT{0, 1, 0};
  Mat4d textureFromWorld{1};
  const Vec3d* origin;
};

/** Identity mapping, in the texture space of the current transform at the texture's directive. */
class TextureSpace {
 public:
  explicit TextureSpace(const TextureContext& context);
  MappedPoint at(const SurfacePoint& point) const;

 private:
  Mat4d textureFromWorld;
  const Vec3d* origin;
};

/** `own` and the parameters of TextureMapping. */
std::vector<ParameterSpec> withMapping(std::vector<ParameterSpec> own);

} // namespace recurse
