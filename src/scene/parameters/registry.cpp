/** @file
 * Error messages for unknown plug-in names.
 */
#include "recurse/scene/parameters/registry.h"

#include <algorithm>
#include <map>
#include <set>

#include "recurse/scene/parameters/otherNames.h"
#include "scene/text/pbrt3.h"

namespace recurse {

namespace {

/** Reason why a plug-in of pbrt-v4 is not supported; empty for other names. */
std::string pbrt4Reason(const std::string& kind, const std::string& name) {
  static const std::map<std::string, std::string> REASONS = {
      {"Film spectral", "is not supported: light is red, green and blue; use the film \"rgb\""},
      {"Texture ptex", "is not supported: Ptex files cannot be read"},
  };
  static const std::set<std::string> NOT_YET = {"Integrator function"};
  const auto found = REASONS.find(kind + " " + name);
  if (found != REASONS.end()) return found->second;
  return NOT_YET.count(kind + " " + name) > 0 ? "of pbrt-v4 is not supported" : "";
}

/** Kind of plug-in in a message. */
std::string titleOf(const std::string& kind) {
  return kind == "MakeNamedMedium" ? "medium type" : kind == "phase" ? "phase function" : kind;
}

/** Suggestion '; did you mean "A" or "B"?', or plug-ins of a different kind with that meaning; empty where no
 * name is near. */
std::string suggestion(const std::string& kind, const std::string& wrong,
                       const std::vector<std::string>& names) {
  constexpr size_t MOST = 3;
  std::vector<std::string> likely = likelyNames(kind, wrong, names);
  for (std::string& name : likely) name = "\"" + name + "\"";
  if (likely.empty())
    for (const PlugInName& meant : plugInsMeantBy(wrong))
      if (meant.kind != kind) likely.push_back(meant.kind + " \"" + meant.name + "\"");
  std::string out;
  for (size_t i = 0; i < likely.size() && i < MOST; ++i) out += (i ? " or " : "; did you mean ") + likely[i];
  return out.empty() ? out : out + "?";
}

} // namespace

std::string unknownPlugInText(const std::string& kind, const std::string& name,
                              const std::vector<std::string>& names) {
  std::string message = "unknown " + titleOf(kind) + " \"" + name + "\"" + suggestion(kind, name, names);
  if (const std::string reason = pbrt4Reason(kind, name); !reason.empty())
    message = titleOf(kind) + " \"" + name + "\" " + reason;
  if (sceneFile::pbrt3::isPlugIn(kind, name)) message += " (pbrt-v3 had it)";
  return message;
}

void reportUnknownPlugIn(const std::string& kind, const ParsedDirective& directive,
                         const std::vector<std::string>& names, Diagnostics& diagnostics) {
  std::string accepted;
  for (const std::string& name : names) accepted += (accepted.empty() ? "\"" : " \"") + name + "\"";
  diagnostics.error(directive.location, unknownPlugInText(kind, directive.type, names), accepted);
}

} // namespace recurse
