/** @file
 * Suggestions for a word that the command line does not know.
 */
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace recurse::apps {

/** An accepted name, and its description in the help. */
using Described = std::pair<std::string, std::string>;

/** "; did you mean A or B?", with `prefix` before each name; empty if nothing is near. Names that `wrong`
 * misspells come first, then names with a description that begins with it, names that contain it, and names
 * with it as a word of their description. */
std::string suggestion(const std::string& wrong, const std::vector<Described>& accepted,
                       const std::string& prefix = {});

} // namespace recurse::apps
