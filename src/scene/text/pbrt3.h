/** @file
 * Signs of the older pbrt-v3 format, which looks much the same; people try such files often.
 */
#pragma once

#include <string>

namespace recurse::sceneFile::pbrt3 {

/** True where a plug-in of this name, after this directive, exists in pbrt-v3 and not in pbrt-v4. */
bool isPlugIn(const std::string& directive, const std::string& plugIn);
/** True for directives that only pbrt-v3 and older have. */
bool isDirective(const std::string& directive);
/** What to write in place of an old parameter type; null where the word is no such type. */
const char* parameterTypeHint(const std::string& type);

/** The advice that goes with the first sign. */
extern const char* const ADVICE;

} // namespace recurse::sceneFile::pbrt3
