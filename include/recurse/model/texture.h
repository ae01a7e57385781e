/** @file
 * Textures, and the values of material parameters: a constant or a texture.
 */
#pragma once

#include "recurse/core/rgb.h"
#include "recurse/model/shape.h"

namespace recurse {

/** A colour that varies over surfaces. Float textures give grey. */
class Texture {
 public:
  virtual ~Texture() = default;
  virtual Rgb value(const SurfacePoint& point) const = 0;
};

/** A material parameter. The constant case costs one branch. */
struct TexturedRgb {
  Rgb constant{0};
  const Texture* texture = nullptr; ///< owned by the scene
  Rgb at(const SurfacePoint& point) const { return texture ? texture->value(point) : constant; }
};

/** Finds textures by name while materials are made. */
class TextureLookup {
 public:
  virtual ~TextureLookup() = default;
  /** The value of a parameter declared withTexture; throws SceneError for a texture that does not exist. */
  virtual TexturedRgb rgb(const Parameters& parameters, const std::string& name) const = 0;
  /** The same for a float parameter: grey. */
  virtual TexturedRgb real(const Parameters& parameters, const std::string& name) const = 0;
};

} // namespace recurse
