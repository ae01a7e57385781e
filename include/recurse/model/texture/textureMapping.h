/** @file
 * From surfaces to the space that textures are defined in: two coordinates, or the points of texture space.
 * Each comes with its change over the footprint of a sample.
 */
#pragma once

#include <vector>

#include "recurse/model/texture/texture.h"

namespace recurse {

/** Coordinates and how they change along the footprint's two axes; zero where it is not known. */
struct MappedPlace {
  Vec2f st{0}, alongX{0}, alongY{0};
  /** Half the size of the footprint's bounding box. */
  Vec2f extent() const { return 0.5f * (glm::abs(alongX) + glm::abs(alongY)); }
};
struct MappedPoint {
  Vec3d p{0};
  Vec3f alongX{0}, alongY{0};
};

/** The axes of the ellipse in which the footprint's cone cuts the surface; zero where it is not known. */
struct FootprintAxes {
  explicit FootprintAxes(const SurfacePoint& point);
  Vec3f x{0}, y{0}; ///< whole lengths, not half of them
};

/** pbrt-v4's `mapping` of textures of two dimensions. */
class TextureMapping {
 public:
  TextureMapping(const Parameters& parameters, const TextureContext& context);
  MappedPlace at(const SurfacePoint& point) const;

 private:
  enum class Kind { UV, SPHERICAL, CYLINDRICAL, PLANAR };
  Vec2d of(const Vec3d& p, Vec3d& ds, Vec3d& dt) const;

  Kind kind = Kind::UV;
  Vec2d scale{1}, delta{0};
  Vec3d axisS{1, 0, 0}, axisT{0, 1, 0};
  Mat4d textureFromWorld{1};
  const Vec3d* origin;
};

/** The point itself, in the space that the current transform made for the texture. */
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
