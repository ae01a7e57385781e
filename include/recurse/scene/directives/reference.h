/** @file
 * Parts of the reference page, generated from the tables that the program itself uses.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/scene/directives/directiveInfo.h"
#include "recurse/scene/parameters/registry.h"

namespace recurse {

/** Tables of the directives and of the parameters of Option, Animate and LightScale, in Markdown. */
std::string directiveReference();
/** For each plug-in a heading, its summary, and a table of its parameters, in Markdown. */
std::string plugInReference(const std::vector<const PlugInInfo*>& plugIns);
std::string plugInReference(const std::vector<PlugInInfo>& plugIns);
/** Reference of all plug-ins in a registry, under a heading with its kind, in Markdown. */
template <class I, class Context> std::string registryReference(const Registry<I, Context>& registry) {
  std::vector<const PlugInInfo*> list;
  for (const auto& entry : registry.entries()) list.push_back(&entry);
  return "## " + registry.kind() + "\n\n" + plugInReference(list);
}

} // namespace recurse
