/** @file
 * Recursive-descent parser of JSON.
 */
#include "importers/assimp/json.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>

#include "recurse/core/io/error.h"

namespace recurse {

namespace {

void appendUtf8(std::string& out, uint32_t code) {
  const auto byte = [&out](uint32_t bits) { out += static_cast<char>(bits); };
  if (code < 0x80) return byte(code);
  if (code < 0x800) {
    byte(0xc0 | code >> 6);
  } else {
    if (code < 0x10000) {
      byte(0xe0 | code >> 12);
    } else {
      byte(0xf0 | code >> 18);
      byte(0x80 | (code >> 12 & 63));
    }
    byte(0x80 | (code >> 6 & 63));
  }
  byte(0x80 | (code & 63));
}

} // namespace

class JsonParser {
 public:
  explicit JsonParser(std::string_view text) : text(text) {
    if (text.starts_with("\xef\xbb\xbf")) at = 3; // byte-order mark
  }

  JsonValue parse() {
    JsonValue value = parseValue(0);
    skipSpace();
    if (at < text.size()) fail("the end of the text");
    return value;
  }

 private:
  using Kind = JsonValue::Kind;
  static constexpr int MAX_DEPTH = 500;

  [[noreturn]] void fail(const std::string& expected) const {
    throw Error("byte " + std::to_string(at) + " of the JSON text should be " + expected);
  }

  void skipSpace() {
    while (at < text.size() && std::string_view(" \t\r\n").find(text[at]) != std::string_view::npos) ++at;
  }
  /** Takes a character after white space, if it is the next one. */
  bool take(char c) {
    skipSpace();
    if (at >= text.size() || text[at] != c) return false;
    ++at;
    return true;
  }
  bool takeWord(std::string_view word) {
    if (!text.substr(at).starts_with(word)) return false;
    at += word.size();
    return true;
  }

  JsonValue parseValue(int depth) {
    if (depth > MAX_DEPTH) fail("less deeply nested");
    JsonValue value;
    skipSpace();
    if (take('{')) {
      parseObject(value, depth);
    } else if (take('[')) {
      parseArray(value, depth);
    } else if (at < text.size() && text[at] == '"') {
      value.kind = Kind::STRING;
      value.string = parseString();
    } else if (takeWord("true") || takeWord("false")) {
      value.kind = Kind::BOOLEAN;
    } else if (!takeWord("null")) {
      value.kind = Kind::NUMBER;
      value.value = parseNumber();
    }
    return value;
  }

  void parseObject(JsonValue& value, int depth) {
    value.kind = Kind::OBJECT;
    if (take('}')) return;
    do {
      skipSpace();
      value.names.push_back(parseString());
      if (!take(':')) fail("':'");
      value.children.push_back(parseValue(depth + 1));
    } while (take(','));
    if (!take('}')) fail("',' or '}'");
  }

  void parseArray(JsonValue& value, int depth) {
    value.kind = Kind::ARRAY;
    if (take(']')) return;
    do value.children.push_back(parseValue(depth + 1));
    while (take(','));
    if (!take(']')) fail("',' or ']'");
  }

  double parseNumber() {
    double number = 0;
    const char* const end = text.data() + text.size();
    const auto [next, error] = std::from_chars(text.data() + at, end, number);
    if (next == text.data() + at) fail("a value");
    at = static_cast<size_t>(next - text.data());
    return error == std::errc() ? number : 0;
  }

  std::string parseString() {
    if (at >= text.size() || text[at] != '"') fail("'\"'");
    ++at;
    std::string out;
    while (true) {
      const size_t end = text.find_first_of("\"\\", at);
      if (end == std::string_view::npos) fail("in a string that ends");
      out += text.substr(at, end - at);
      at = end + 1;
      if (text[end] == '"') return out;
      parseEscape(out);
    }
  }

  void parseEscape(std::string& out) {
    static constexpr std::string_view NAMES = "\"\\/bfnrt", CHARACTERS = "\"\\/\b\f\n\r\t";
    if (at < text.size() && text[at] == 'u') {
      ++at;
      uint32_t code = parseHex();
      if (code >> 10 == 0x36 && takeWord("\\u")) // a surrogate pair
        code = 0x10000 + ((code & 0x3ff) << 10 | (parseHex() & 0x3ff));
      return appendUtf8(out, code);
    }
    const size_t which = at < text.size() ? NAMES.find(text[at]) : std::string_view::npos;
    if (which == std::string_view::npos) fail("a character that can be escaped");
    out += CHARACTERS[which];
    ++at;
  }

  uint32_t parseHex() {
    uint32_t code = 0;
    const std::string_view digits = text.substr(at, 4);
    const auto [next, error] = std::from_chars(digits.data(), digits.data() + digits.size(), code, 16);
    if (digits.size() < 4 || next != digits.data() + 4 || error != std::errc())
      fail("four hexadecimal digits");
    at += 4;
    return code;
  }

  const std::string_view text;
  size_t at = 0;
};

JsonValue JsonValue::parse(std::string_view text) { return JsonParser(text).parse(); }

const JsonValue& JsonValue::operator[](std::string_view name) const {
  static const JsonValue ABSENT;
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? ABSENT : children[static_cast<size_t>(found - names.begin())];
}

const JsonValue& JsonValue::operator[](size_t index) const {
  static const JsonValue ABSENT;
  return index < children.size() ? children[index] : ABSENT;
}

size_t JsonValue::index() const {
  const bool isIndex = kind == Kind::NUMBER && value >= 0 && value < 0x1p53;
  return isIndex ? static_cast<size_t>(value) : std::numeric_limits<size_t>::max();
}

} // namespace recurse
