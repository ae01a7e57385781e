/** @file
 * Full-text search in the reference of scene files.
 */
#pragma once

#include <string>

namespace recurse::apps {

/** Lines that answer `recurse reference WORD` for a word that is no name: the plug-ins that the word means,
 * then the directives, plug-ins and parameters whose name or text has a word that begins with it. Upper and
 * lower case are the same, and so are singular and plural. Empty where nothing is found. */
std::string searchReference(const std::string& word);

} // namespace recurse::apps
