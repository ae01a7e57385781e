/** @file
 * Control characters of ASCII and of ISO 6429 in UTF-8.
 */
#include "recurse/core/io/terminalText.h"

#include <algorithm>
#include <cstdint>

namespace recurse {

namespace {

uint8_t byteAt(const std::string& text, size_t i) {
  return i < text.size() ? static_cast<uint8_t>(text[i]) : 0;
}

/** Length of the UTF-8 character that begins at `i`, 1 to 4 [bytes]; 0 where none does, as in overlong forms,
 * surrogates, and above U+10FFFF (the Unicode Standard, table 3-7). */
size_t characterBytes(const std::string& text, size_t i) {
  const uint8_t first = byteAt(text, i);
  if (first < 0x80) return 1;
  if (first < 0xc2 || first > 0xf4) return 0;
  const uint8_t second = byteAt(text, i + 1);
  const uint8_t lowest = first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80;
  const uint8_t highest = first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
  if (second < lowest || second > highest) return 0;
  const size_t count = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  for (size_t k = 2; k < count; ++k)
    if ((byteAt(text, i + k) & 0xc0) != 0x80) return 0;
  return count;
}

bool isControl(const std::string& text, size_t i, size_t bytes) {
  const uint8_t first = byteAt(text, i);
  return bytes == 1 ? first < 0x20 || first == 0x7f
                    : bytes == 2 && first == 0xc2 && byteAt(text, i + 1) < 0xa0;
}

} // namespace

TextCharacter characterAt(const std::string& text, size_t i) {
  const size_t bytes = characterBytes(text, i);
  return {std::max<size_t>(bytes, 1), bytes > 0 && !isControl(text, i, bytes)};
}

std::string terminalText(const std::string& text) {
  static constexpr char DIGITS[] = "0123456789abcdef";
  std::string out;
  out.reserve(text.size());
  for (size_t i = 0; i < text.size();) {
    const TextCharacter c = characterAt(text, i);
    const bool isShown = c.isPlain || text[i] == '\n' || text[i] == '\t';
    for (size_t k = i; k < i + c.bytes; ++k) {
      const uint8_t byte = byteAt(text, k);
      if (isShown)
        out += text[k];
      else
        out += {'\\', 'x', DIGITS[byte >> 4], DIGITS[byte & 15]};
    }
    i += c.bytes;
  }
  return out;
}

bool hasControlCharacters(const std::string& text) {
  return terminalText(text) != text || text.find_first_of("\n\t") != std::string::npos;
}

} // namespace recurse
