/** @file
 * Named settings of a render, for commands that render a scene in several ways.
 */
#pragma once

#include <string>
#include <vector>

#include "apps/options/renderOptions.h"

namespace recurse::apps {

/** Run with its options, as requested. */
struct Run {
  std::string name;
  RenderOptions options;
  ParsedDirective integrator; ///< set once the scene is loaded
};

/** Parses NAME=OPTIONS with the parser of `recurse render`, whose defaults are the options in `common`.
 * `option` is its name for messages. `refused`: options that the command itself sets. Throws Error
 * (BAD_USAGE). */
Run parseRun(const std::string& option, const std::string& text, const RenderOptions& common,
             const std::vector<const char*>& refused);

} // namespace recurse::apps
