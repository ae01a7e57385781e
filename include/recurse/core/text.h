/** @file
 * Text with numbers in it.
 */
#pragma once

#include <cstdio>
#include <string>

namespace recurse {

/** What std::printf would print; `pattern` must suit the values. */
std::string formatted(const char* pattern, auto... values) {
  std::string text(static_cast<size_t>(std::snprintf(nullptr, 0, pattern, values...)), '\0');
  std::snprintf(text.data(), text.size() + 1, pattern, values...);
  return text;
}

} // namespace recurse
