/** @file
 * The pieces of the reference page, made from the same tables that the program works with.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/scene/registry.h"

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

/** How a parameter is declared in a scene file: `"float radius"`. */
std::string declarationText(const ParameterSpec& spec);
/** What values it takes: range, choices, count; empty where anything goes. */
std::string rangeText(const ParameterSpec& spec);

/** Markdown: a table of the directives, and one of the options. */
std::string directiveReference();
/** Markdown: for each plug-in a heading, its summary, and a table of its parameters. */
std::string plugInReference(const std::vector<const PlugInInfo*>& plugIns);
std::string plugInReference(const std::vector<PlugInInfo>& plugIns);
/** The same for everything in a registry, under a heading with its kind. */
template <class I, class Context> std::string registryReference(const Registry<I, Context>& registry) {
  std::vector<const PlugInInfo*> list;
  for (const auto& entry : registry.entries()) list.push_back(&entry);
  return "## " + registry.kind() + "\n\n" + plugInReference(list);
}

} // namespace recurse
