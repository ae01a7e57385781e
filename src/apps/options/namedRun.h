/** @file
 * Settings of a render under a name, as commands take them that render a scene in several ways.
 */
#pragma once

#include <string>
#include <vector>

#include "apps/options/renderOptions.h"

namespace recurse::apps {

/** A run as it was asked for. */
struct Run {
  std::string name;
  RenderOptions options;
  ParsedDirective integrator; ///< set by whoever loads the scene
};

/** `text` is NAME=OPTIONS, understood by the very parser of `recurse render`; what it does not say is as in
 * `common`. `option` is its name for messages. `refused` are options that the command decides about. Throws
 * Error (BAD_USAGE). */
Run parseRun(const std::string& option, const std::string& text, const RenderOptions& common,
             const std::vector<const char*>& refused);

} // namespace recurse::apps
