/** @file
 * Events in the words of path classes, and the definition of a class.
 */
#pragma once

#include <cstdint>
#include <string>

namespace recurse {

/** Events of a path between L and E: specular (delta), diffuse (non-delta) and volume scattering. */
enum class PathEvent : uint8_t { S, D, V };

/** Path class: the name of its film layer, and its expression. */
struct PathClass {
  std::string name;
  std::string expression;
};

} // namespace recurse
