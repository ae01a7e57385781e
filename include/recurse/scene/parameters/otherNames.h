/** @file
 * Names of pbrt-v3 and common words for plug-ins that have another name here.
 */
#pragma once

#include <string>
#include <vector>

namespace recurse {

/** A plug-in by the kind of its registry, such as "Material", and its name. */
struct PlugInName {
  std::string kind;
  std::string name;

  bool operator==(const PlugInName&) const = default;
};

/** A word and the plug-ins that it means, the likeliest first. */
struct OtherName {
  std::string word; ///< in lower case
  std::vector<PlugInName> meant;
};

/** The table of other names, sorted by word. */
const std::vector<OtherName>& otherNames();

/** Plug-ins that a word means, the likeliest first; upper and lower case are the same. Empty for a word that
 * is not in the table. */
std::vector<PlugInName> plugInsMeantBy(const std::string& word);

/** Names among `names`, of the kind `kind`, that `wrong` may stand for: those that it means, then those that
 * it misspells. */
std::vector<std::string> likelyNames(const std::string& kind, const std::string& wrong,
                                     const std::vector<std::string>& names);

} // namespace recurse
