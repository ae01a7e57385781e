/** @file
 * Reader of little-endian values in the bytes of a file, for little-endian hosts. Every access is checked
 * against the size of the file, since its counts and offsets may be wrong.
 */
#pragma once

#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "recurse/core/io/error.h"

namespace recurse {

static_assert(std::endian::native == std::endian::little, "ByteReader does not swap bytes");

class ByteReader {
 public:
  /** The bytes must outlive the reader; `name` is for messages. */
  ByteReader(std::string name, std::string_view bytes) : name(std::move(name)), bytes(bytes) {}

  uint64_t size() const { return bytes.size(); }
  const std::string& source() const { return name; }

  [[noreturn]] void fail(uint64_t offset, const std::string& what) const {
    throw Error(name + ": at byte " + std::to_string(offset) + ": " + what);
  }

  /** View of `count` bytes from an offset. Throws Error naming `what` beyond the end. */
  std::string_view part(uint64_t offset, uint64_t count, const char* what) const {
    if (offset > bytes.size() || count > bytes.size() - offset)
      fail(offset, std::string(what) + " would take " + std::to_string(count) + " bytes, and the file has " +
                       std::to_string(bytes.size()) + " in all");
    return bytes.substr(offset, count);
  }

  /** Reads a number. Throws Error naming `what` beyond the end, or where it is not finite. */
  template <class T> T at(uint64_t offset, const char* what) const {
    static_assert(std::is_arithmetic_v<T>);
    T value;
    std::memcpy(&value, part(offset, sizeof(T), what).data(), sizeof(T));
    if constexpr (std::is_floating_point_v<T>)
      if (!std::isfinite(value)) fail(offset, std::string(what) + " is not finite");
    return value;
  }

  /** Reads a count or an offset, an int32: not negative, at most `highest`. Throws Error otherwise. */
  uint64_t count(uint64_t offset, const char* what, uint64_t highest) const {
    const auto value = at<int32_t>(offset, what);
    if (value < 0 || static_cast<uint64_t>(value) > highest)
      fail(offset, std::string(what) + " is " + std::to_string(value) + "; it can be 0 to " +
                       std::to_string(highest));
    return static_cast<uint64_t>(value);
  }

  /** Reads a name from a field of `length` bytes: up to a zero byte, or the whole field. */
  std::string text(uint64_t offset, uint64_t length, const char* what) const {
    const std::string_view field = part(offset, length, what);
    return std::string(field.substr(0, field.find('\0')));
  }

 private:
  std::string name;
  std::string_view bytes;
};

} // namespace recurse
