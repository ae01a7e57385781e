/** @file
 * Text tools: formatted numbers, lower case, percent escapes.
 */
#pragma once

#include <cctype>
#include <cstdio>
#include <string>

namespace recurse {

/** Text that std::printf would print; `pattern` must suit the values. */
std::string formatted(const char* pattern, auto... values) {
  std::string text(static_cast<size_t>(std::snprintf(nullptr, 0, pattern, values...)), '\0');
  std::snprintf(text.data(), text.size() + 1, pattern, values...);
  return text;
}

/** Text with the letters A to Z replaced by a to z. */
inline std::string lowerCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/** Decoded text of a URL: "%20" and the like become the bytes that they name; other percent signs stay. */
std::string percentDecoded(const std::string& text);

} // namespace recurse
