/** @file
 * The text of `recurse` without arguments.
 */
#pragma once

#include <string>

namespace recurse::apps {

/** Ten lines with examples of the commands that a first render needs. */
std::string quickStart();

} // namespace recurse::apps
