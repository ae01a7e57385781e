/** @file
 * Shader scripts of Quake III, restricted to light: the appearance, the transparency and the emission of
 * surfaces.
 */
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recurse/core/io/error.h"
#include "recurse/core/math/vector.h"

namespace recurse {

struct GameShader {
  struct Stage {
    std::string image;                    ///< first one of an animation; empty: none
    std::string blendSource, blendTarget; ///< lower case; empty: opaque
    std::optional<float> alphaThreshold;
    bool showsLowAlpha = false; ///< alpha below the threshold is visible, instead of above
    bool isLightmap = false, isEnvironment = false;
    bool isAdditive() const { return blendSource == "gl_one" && blendTarget == "gl_one"; }
    bool isBlended() const { return blendSource == "gl_src_alpha"; }
  };
  struct Sun {
    Vec3d colour;
    double intensity = 0, azimuth = 0, elevation = 0; ///< azimuth and elevation of its position [degrees]
  };

  bool isSky = false, isInvisible = false, isLiquid = false, isTwoSided = false;
  double surfaceLight = 0; ///< in the units of q3map
  std::string lightImage, editorImage, skyBox;
  std::optional<Sun> sun;
  std::vector<Stage> stages;

  /** Stage that determines the look of the surface; null where none does. */
  const Stage* base() const;
};

/** Shaders by name in lower case, without extension. */
using GameShaders = std::map<std::string, GameShader>;

/** Adds the definitions of a script; the first definition of a name wins. `name` is for warnings, which
 * report text that is not understood. */
void readGameShaders(const std::string& name, const std::string& text, GameShaders& shaders,
                     std::vector<std::string>& warnings);

/** Name in the form of GameShaders' keys. */
std::string gameShaderName(const std::string& name);

} // namespace recurse
