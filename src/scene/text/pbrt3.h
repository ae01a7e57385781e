/** @file
 * Recognition of the older pbrt-v3 format, which is similar and a common mistake.
 */
#pragma once

#include <string>

namespace recurse::sceneFile::pbrt3 {

/** True where the directive has a plug-in of this name in pbrt-v3 and not in pbrt-v4. */
bool isPlugIn(const std::string& directive, const std::string& plugIn);
/** True for directives that exist only in pbrt-v3 and older. */
bool isDirective(const std::string& directive);
/** Replacement of an old parameter type; null where the word is not an old type. */
const char* parameterTypeHint(const std::string& type);

/** Advice shown with the first sign of pbrt-v3. */
extern const char* const ADVICE;

} // namespace recurse::sceneFile::pbrt3
