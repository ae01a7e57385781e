/** @file
 * Names and permitted positions of the directives of a scene file.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Part of a scene file in which a directive is permitted. */
enum class DirectiveScope { ANYWHERE, BEFORE_WORLD, IN_WORLD };

/** Directive, for the reference page. */
struct DirectiveInfo {
  std::string name;
  std::string arguments; ///< syntax of the arguments
  DirectiveScope place = DirectiveScope::ANYWHERE;
  std::string summary; ///< one line
};

/** Every directive of a scene file, in alphabetical order. */
std::vector<DirectiveInfo> directiveInfos();
/** Options that `Option "name" value` may set. */
const std::vector<ParameterSpec>& optionSpecs();

} // namespace recurse
