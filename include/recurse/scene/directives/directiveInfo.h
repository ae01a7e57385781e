/** @file
 * What the directives of a scene file are called, and where they may stand.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Where a directive may stand. */
enum class DirectivePlace { ANYWHERE, BEFORE_WORLD, IN_WORLD };

struct DirectiveInfo {
  std::string name;
  std::string arguments; ///< how they are written
  DirectivePlace place = DirectivePlace::ANYWHERE;
  std::string summary; ///< one line
};

/** Every directive of a scene file, in alphabetical order. */
std::vector<DirectiveInfo> directiveInfos();
/** What `Option "name" value` may set. */
const std::vector<ParameterSpec>& optionSpecs();

} // namespace recurse
