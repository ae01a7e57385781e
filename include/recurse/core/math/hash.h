/** @file
 * Hash of data that detects accidental changes; not secure against forgery.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

namespace recurse {

/** FNV-1a of 64 bits (Fowler, Noll, Vo; RFC 9923). */
class Hash {
 public:
  void add(const void* data, size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (size_t i = 0; i < size; ++i) state = (state ^ bytes[i]) * 0x100000001b3ull;
  }
  /** Adds the length and the characters, so that "ab", "c" differs from "a", "bc". */
  void add(const std::string& text) {
    const uint64_t size = text.size();
    add(&size, sizeof size);
    add(text.data(), text.size());
  }
  /** The hash as 16 hexadecimal digits. */
  std::string text() const {
    char digits[17];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(state));
    return digits;
  }

 private:
  uint64_t state = 0xcbf29ce484222325ull;
};

} // namespace recurse
