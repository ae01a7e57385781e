/** @file
 * Textures, and the values of material parameters: a constant or a texture.
 */
#pragma once

#include "recurse/core/math/rgb.h"
#include "recurse/model/shape/shape.h"

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
  float lowest = -INFINITE,
        highest = INFINITE; ///< of the parameter: as in pbrt, a texture's values are held to it
  Rgb at(const SurfacePoint& point) const {
    return texture ? clamp(texture->value(point), lowest, highest) : constant;
  }
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

/** The value of a float parameter declared withTexture, where there may be no textures. */
TexturedRgb realOrTexture(const TextureLookup* textures, const Parameters& parameters,
                          const std::string& name);

/** What makers of textures are given besides parameters. */
struct TextureContext {
  const TextureLookup& textures;
  bool spectrum = true;      ///< false: a float texture, which gives grey
  Mat4d worldFromTexture{1}; ///< as the file has it
  const Vec3d* sceneOrigin =
      nullptr; ///< what was taken off positions, known when all is built; null: nothing

  /** A parameter declared by textureValue: a colour or spectrum texture, or a number or float texture. */
  TexturedRgb value(const Parameters& parameters, const std::string& name) const;
  /** Throws SceneError unless the texture is of the only kind that this class can be. */
  void requireKind(const Parameters& parameters, bool spectrum) const;
};

/** A value of a texture's own kind, or another texture of this kind. */
ParameterSpec textureValue(const std::string& name, const std::string& defaultText,
                           const std::string& description);

} // namespace recurse
