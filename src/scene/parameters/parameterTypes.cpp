/** @file
 * Table of parameter types.
 */
#include "scene/parameters/parameterTypes.h"

#include <array>

namespace recurse::sceneFile {

const TypeTraits& traitsOf(ParameterType type) {
  // Entries in the order of the enumeration.
  static constexpr std::array<TypeTraits, 10> TABLE = {{
      {"bool", nullptr, 0, "true or false"},
      {"integer", nullptr, 1, "a whole number"},
      {"float", nullptr, 1, "a number"},
      {"point2", nullptr, 2, "two numbers for a point"},
      {"vector2", nullptr, 2, "two numbers for a vector"},
      {"point3", "point", 3, "three numbers for a point"},
      {"vector3", "vector", 3, "three numbers for a vector"},
      {"normal", "normal3", 3, "three numbers for a normal"},
      {"string", nullptr, 0, "a string in quotes"},
      {"rgb", nullptr, 0, "a colour"},
  }};
  return TABLE[static_cast<size_t>(type)];
}

bool acceptsType(ParameterType type, bool textured, std::string_view typeWord) {
  if (typeWord == "texture") return textured;
  if (type == ParameterType::SPECTRUM)
    return typeWord == "rgb" || typeWord == "spectrum" || typeWord == "blackbody" || typeWord == "float";
  const TypeTraits& traits = traitsOf(type);
  return typeWord == traits.word || (traits.oldWord && typeWord == traits.oldWord);
}

} // namespace recurse::sceneFile
