/** @file
 * Reader of JSON (RFC 8259).
 */
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace recurse {

/** Value of a JSON text. What is absent is null, so that a path of names needs no checks on its way. */
class JsonValue {
 public:
  /** Throws Error with the byte at which the text is no JSON. */
  static JsonValue parse(std::string_view text);

  /** Member of an object; null where there is none. */
  const JsonValue& operator[](std::string_view name) const;
  /** Element of an array; null beyond its end. */
  const JsonValue& operator[](size_t index) const;
  const std::vector<JsonValue>& elements() const { return children; }
  size_t size() const { return children.size(); }

  double number(double otherwise) const { return kind == Kind::NUMBER ? value : otherwise; }
  /** Number as an index; the largest size_t where it is none. */
  size_t index() const;
  /** Decoded text of a string; empty for other values. */
  const std::string& text() const { return string; }

 private:
  friend class JsonParser;
  enum class Kind { NONE, BOOLEAN, NUMBER, STRING, ARRAY, OBJECT };

  Kind kind = Kind::NONE;
  double value = 0;
  std::string string;
  std::vector<std::string> names; ///< of the children of an object
  std::vector<JsonValue> children;
};

} // namespace recurse
