/** @file
 * Recognition of directives, for resynchronisation after an error.
 */
#pragma once

#include "scene/text/lexer.h"

namespace recurse::sceneFile {

/** True for a word that is the name of a directive. */
bool isDirectiveName(const Token& token);

} // namespace recurse::sceneFile
