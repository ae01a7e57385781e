/** @file
 * Reporting of plug-in names that do not exist.
 */
#include "recurse/scene/parameters/registry.h"

#include <map>
#include <set>

#include "scene/text/pbrt3.h"

namespace recurse {

namespace {

/** Why a name that pbrt-v4 has is not taken; empty for others. */
std::string pbrt4Reason(const std::string& kind, const std::string& name) {
  static const std::map<std::string, std::string> REASONS = {
      {"Film spectral", "is not there: light is red, green and blue here; the film \"rgb\" has the picture"},
      {"Texture ptex", "is not there: Ptex files are not read"},
  };
  static const std::set<std::string> NOT_YET = {"Integrator function"};
  const auto found = REASONS.find(kind + " " + name);
  if (found != REASONS.end()) return found->second;
  return NOT_YET.count(kind + " " + name) > 0 ? "of pbrt-v4 is not rendered here" : "";
}

} // namespace

void reportUnknownPlugIn(const std::string& kind, const ParsedDirective& directive,
                         const std::vector<std::string>& names, Diagnostics& diagnostics) {
  std::string message = "unknown " + kind + " \"" + directive.type + "\"";
  const auto near = nearestNames(directive.type, names);
  for (size_t i = 0; i < near.size(); ++i) message += (i ? " or \"" : "; did you mean \"") + near[i] + "\"";
  if (!near.empty()) message += "?";
  if (const std::string reason = pbrt4Reason(kind, directive.type); !reason.empty())
    message = kind + " \"" + directive.type + "\" " + reason;
  if (sceneFile::pbrt3::isPlugIn(kind, directive.type)) message += " (pbrt-v3 had it)";
  std::string accepted;
  for (const std::string& name : names) accepted += (accepted.empty() ? "\"" : " \"") + name + "\"";
  diagnostics.error(directive.location, message, accepted);
}

} // namespace recurse
