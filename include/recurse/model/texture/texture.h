/** @file
 * Textures, and the values of material parameters: constants or textures.
 */
#pragma once

#include "recurse/core/math/rgb.h"
#include "recurse/model/shape/shape.h"

namespace recurse {

/** Colour that varies over surfaces. Float textures return grey. Immutable; any thread may call it. */
class Texture {
 public:
  virtual ~Texture() = default;
  /** Linear value at a point, not clamped. Filtered over the point's footprint, which alpha and displacement
   * leave unknown. */
  virtual Rgb value(const SurfacePoint& point) const = 0;
};

/** Value of a material parameter. A constant costs one branch. */
struct TexturedRgb {
  Rgb constant{0};
  const Texture* texture = nullptr; ///< owned by the scene
  float lowest = -INFINITE,
        highest = INFINITE; ///< range of the parameter, to which texture values are clamped as in pbrt
  Rgb at(const SurfacePoint& point) const {
    return texture ? clamp(texture->value(point), lowest, highest) : constant;
  }
};

/** Lookup of textures by name, valid during construction only. The scene owns the textures. */
class TextureLookup {
 public:
  virtual ~TextureLookup() = default;
  /** Value of a parameter declared withTexture; throws SceneError for a texture that does not exist. */
  virtual TexturedRgb rgb(const Parameters& parameters, const std::string& name) const = 0;
  /** Value of a float parameter declared withTexture, as grey. */
  virtual TexturedRgb real(const Parameters& parameters, const std::string& name) const = 0;
};

/** Value of a float parameter declared withTexture; throws SceneError for a texture without `textures`. */
TexturedRgb realOrTexture(const TextureLookup* textures, const Parameters& parameters,
                          const std::string& name);

/** Arguments of makers of textures besides parameters. */
struct TextureContext {
  const TextureLookup& textures;
  bool spectrum = true;      ///< false: a float texture, which gives grey
  Mat4d worldFromTexture{1}; ///< as in the file
  const Vec3d* sceneOrigin =
      nullptr; ///< world coordinates of the scene's origin; set later, so read it in value(); null: zero

  /** Value of a parameter declared by textureValue(), of the texture's kind. Throws SceneError for a colour
   * in a float texture, and for a negative constant in a spectrum texture. */
  TexturedRgb value(const Parameters& parameters, const std::string& name) const;
  /** Throws SceneError unless the texture is of the only supported kind: a spectrum texture if `spectrum`,
   * else a float texture. */
  void requireKind(const Parameters& parameters, bool spectrum) const;
};

/** Declares a parameter of a texture's own kind: a constant, or a texture of this kind. */
ParameterSpec textureValue(const std::string& name, const std::string& defaultText,
                           const std::string& description);

} // namespace recurse
