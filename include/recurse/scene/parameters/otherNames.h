/** @file
 * Alternative names of plug-ins: names of pbrt-v3, and common words.
 */
#pragma once

#include <string>
#include <vector>

namespace recurse {

/** Plug-in, by the kind of its registry, such as "Material", and its name. */
struct PlugInName {
  std::string kind;
  std::string name;

  bool operator==(const PlugInName&) const = default;
};

/** Word with the plug-ins that it may refer to, most likely first. */
struct OtherName {
  std::string word; ///< in lower case
  std::vector<PlugInName> meant;
};

/** Table of alternative names, sorted by word. */
const std::vector<OtherName>& otherNames();

/** Plug-ins that a word may refer to, most likely first; case-insensitive. Empty for a word that is not in
 * the table. */
std::vector<PlugInName> plugInsMeantBy(const std::string& word);

/** Members of `names`, of the kind `kind`, that `wrong` may refer to: first by the table, then by a similar
 * spelling. */
std::vector<std::string> likelyNames(const std::string& kind, const std::string& wrong,
                                     const std::vector<std::string>& names);

} // namespace recurse
