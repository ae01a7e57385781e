/** @file
 * What there is to know about each type of parameter, in one table.
 */
#pragma once

#include <string_view>

#include "recurse/scene/parameters/parsedDirective.h"

namespace recurse::sceneFile {

struct TypeTraits {
  const char* word;        ///< that declares it
  const char* oldWord;     ///< also accepted; may be null
  size_t numbersEach;      ///< numbers that make one value; 0 for types that are not numbers
  const char* description; ///< of one value
};

const TypeTraits& traitsOf(ParameterType type);

/** True when a value declared with `typeWord` may be given for the parameter. */
bool acceptsType(ParameterType type, bool textured, std::string_view typeWord);

} // namespace recurse::sceneFile
