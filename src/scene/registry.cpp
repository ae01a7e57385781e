/** @file
 * Reporting of plug-in names that do not exist.
 */
#include "recurse/scene/registry.h"

#include "scene/pbrt3.h"

namespace recurse {

void reportUnknownPlugIn(const std::string& kind, const ParsedDirective& directive,
                         const std::vector<std::string>& names, Diagnostics& diagnostics) {
  std::string message = "unknown " + kind + " \"" + directive.type + "\"";
  const auto near = nearestNames(directive.type, names);
  for (size_t i = 0; i < near.size(); ++i) message += (i ? " or \"" : "; did you mean \"") + near[i] + "\"";
  if (!near.empty()) message += "?";
  if (sceneFile::pbrt3::isPlugIn(kind, directive.type)) message += " (pbrt-v3 had it)";
  std::string accepted;
  for (const std::string& name : names) accepted += (accepted.empty() ? "\"" : " \"") + name + "\"";
  diagnostics.error(directive.location, message, accepted);
}

} // namespace recurse
