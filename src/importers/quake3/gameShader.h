/** @file
 * Shader scripts of Quake III, as far as light goes: what a surface looks like, whether it can be seen
 * through, and what it emits.
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
    std::string image;                    ///< of an animation the first; empty: none of its own
    std::string blendSource, blendTarget; ///< lower case; empty: opaque
    std::optional<float> alphaThreshold;
    bool showsLowAlpha = false; ///< what is below the threshold is seen, not what is above
    bool isLightmap = false, isEnvironment = false;
    bool isAdditive() const { return blendSource == "gl_one" && blendTarget == "gl_one"; }
    bool isBlended() const { return blendSource == "gl_src_alpha"; }
  };
  struct Sun {
    Vec3d colour;
    double intensity = 0, azimuth = 0, elevation = 0; ///< azimuth and elevation of where it stands [degrees]
  };

  bool isSky = false, isInvisible = false, isLiquid = false, isTwoSided = false;
  double surfaceLight = 0; ///< in the units of q3map
  std::string lightImage, editorImage, skyBox;
  std::optional<Sun> sun;
  std::vector<Stage> stages;

  /** The stage that says what the surface looks like; null where none does. */
  const Stage* base() const;
};

/** By name in lower case, without extension. */
using GameShaders = std::map<std::string, GameShader>;

/** Adds the definitions of a script; of a name that is there already the first one counts. `name` is for
 * warnings, which tell of what is not understood. */
void readGameShaders(const std::string& name, const std::string& text, GameShaders& shaders,
                     std::vector<std::string>& warnings);

/** A name as GameShaders has it. */
std::string gameShaderName(const std::string& name);

} // namespace recurse
