/** @file
 * What may be meant by a word that the command line does not know.
 */
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace recurse::apps {

/** A name that is accepted, and what help says of it. */
using Described = std::pair<std::string, std::string>;

/** "; did you mean A or B?"; empty where nothing is near. Names that `wrong` misspells come first, then
 * those whose description begins with it, that contain it, or whose description has it as a word. Each is
 * shown behind the prefix. */
std::string suggestion(const std::string& wrong, const std::vector<Described>& accepted,
                       const std::string& prefix = {});

} // namespace recurse::apps
