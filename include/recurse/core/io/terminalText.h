/** @file
 * Text from files on a terminal.
 */
#pragma once

#include <string>

namespace recurse {

/** The text with control characters, other than line ends and tabs, as two hexadecimal digits behind a
 * backslash and an x, and bytes that are not UTF-8 too: so no name or metadata moves the cursor or gives a
 * terminal commands. */
std::string terminalText(const std::string& text);

/** True where the text has a control character, a line end or a tab. */
bool hasControlCharacters(const std::string& text);

} // namespace recurse
