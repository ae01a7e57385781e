/** @file
 * The pieces of the reference page, made from the same tables that the program works with.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/scene/directives/directiveInfo.h"
#include "recurse/scene/parameters/registry.h"

namespace recurse {

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
