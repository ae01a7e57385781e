/** @file
 * Safe display of text from files on a terminal.
 */
#pragma once

#include <string>

namespace recurse {

/** A character of UTF-8 text; or a byte that is not part of one. */
struct TextCharacter {
  size_t bytes; ///< 1 to 4
  bool isPlain; ///< false: a control character, or not UTF-8
};

/** Character that begins at byte `i` of the text, before its end. */
TextCharacter characterAt(const std::string& text, size_t i);

/** Text with control characters, other than line ends and tabs, and with bytes that are not UTF-8 replaced by
 * backslash, x and two hexadecimal digits. No name and no metadata can thus move the cursor or give a
 * terminal commands. */
std::string terminalText(const std::string& text);

/** True where the text has a control character, a line end, a tab, or a byte that is not UTF-8. */
bool hasControlCharacters(const std::string& text);

} // namespace recurse
