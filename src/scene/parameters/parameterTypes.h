/** @file
 * Properties of all parameter types, in one table.
 */
#pragma once

#include <string_view>

#include "recurse/scene/parameters/parsedDirective.h"

namespace recurse::sceneFile {

struct TypeTraits {
  const char* word;        ///< type word of its declaration
  const char* oldWord;     ///< older type word, also accepted; may be null
  size_t numbersEach;      ///< count of numbers in one value; 0 for types that are not numbers
  const char* description; ///< of one value
};

const TypeTraits& traitsOf(ParameterType type);

/** True when a value declared with `typeWord` is valid for the parameter. */
bool acceptsType(ParameterType type, bool textured, std::string_view typeWord);

} // namespace recurse::sceneFile
