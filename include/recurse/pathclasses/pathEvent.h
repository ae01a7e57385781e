/** @file
 * The events that the words of path classes are made of, and the name of a class.
 */
#pragma once

#include <cstdint>
#include <string>

namespace recurse {

/** The events of a path between its ends. */
enum class PathEvent : uint8_t { S, D, V };

/** One class: a name for its film layer and its expression. */
struct PathClass {
  std::string name;
  std::string expression;
};

} // namespace recurse
