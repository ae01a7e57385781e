/** @file
 * Safe display of text from files on a terminal.
 */
#pragma once

#include <string>

namespace recurse {

/** Text with control characters, other than line ends and tabs, and with bytes that are not UTF-8 replaced by
 * backslash, x and two hexadecimal digits. No name and no metadata can thus move the cursor or give a
 * terminal commands. */
std::string terminalText(const std::string& text);

/** True where the text has a control character, a line end, a tab, or a byte that is not UTF-8. */
bool hasControlCharacters(const std::string& text);

} // namespace recurse
