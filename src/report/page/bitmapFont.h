/** @file
 * Text in pictures without any font of the system: a fixed one, five by eight dots a letter.
 */
#pragma once

#include <string>

#include "recurse/core/image/image.h"

namespace recurse {

/** Dots from one letter or line to the next. */
constexpr int LETTER_STEP = 6, LINE_STEP = 10;

/** Draws ASCII text with its upper left corner at (x, y); every dot is `size` pixels wide. Dots outside of
 * the picture are left out; bytes that are not ASCII are drawn as boxes. */
void drawText(Image& image, int x, int y, const std::string& text, const Rgb& colour, int size);

} // namespace recurse
