/** @file
 * Text with numbers in it, in lower case, and with escapes.
 */
#pragma once

#include <cctype>
#include <cstdio>
#include <string>

namespace recurse {

/** What std::printf would print; `pattern` must suit the values. */
std::string formatted(const char* pattern, auto... values) {
  std::string text(static_cast<size_t>(std::snprintf(nullptr, 0, pattern, values...)), '\0');
  std::snprintf(text.data(), text.size() + 1, pattern, values...);
  return text;
}

/** The text with letters A to Z as a to z. */
inline std::string lowerCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/** The text of a URL: "%20" and the like stand for the bytes they name, and other percent signs stay. */
std::string percentDecoded(const std::string& text);

} // namespace recurse
