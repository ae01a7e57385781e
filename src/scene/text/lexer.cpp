/** @file
 * Lexer of scene files.
 */
#include "scene/text/lexer.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "recurse/core/io/text.h"

namespace recurse::sceneFile {

namespace {

constexpr bool isBlank(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }
constexpr bool endsWord(char c) { return isBlank(c) || c == '"' || c == '[' || c == ']' || c == '#'; }
constexpr bool isDigit(char c) { return c >= '0' && c <= '9'; }

/** Maximum length of a file's text quoted in a message [characters]. */
constexpr size_t SHOWN_LENGTH = 40;

int limited(int64_t n) { return static_cast<int>(std::min<int64_t>(n, std::numeric_limits<int>::max())); }

/** Reads a number at `begin`; null where there is none, or where no delimiter follows it. */
const char* parseNumber(const char* begin, const char* end, double& value) {
  const char* p = begin;
  if (p < end && *p == '+') ++p; // std::from_chars accepts only a minus sign
  const char* first = p < end && *p == '-' && p == begin ? p + 1 : p;
  // from_chars would also accept words like "inf" and "nan".
  if (first >= end || !(isDigit(*first) || *first == '.')) return nullptr;
  const auto [stop, error] = std::from_chars(p, end, value);
  if (error != std::errc() || (stop < end && !endsWord(*stop))) return nullptr;
  return stop;
}

std::string printable(std::string_view text) {
  std::string out;
  for (char c : text.substr(0, SHOWN_LENGTH)) {
    const auto byte = static_cast<unsigned char>(c);
    out += byte < 0x20 || byte == 0x7f ? '?' : c;
  }
  // The cut must not split a UTF-8 character.
  if (text.size() > SHOWN_LENGTH) {
    while (!out.empty() && (static_cast<unsigned char>(out.back()) & 0x80)) out.pop_back();
    out += "...";
  }
  return out;
}

} // namespace

SourceLocation Token::location() const {
  SourceLocation where;
  if (!source || !source->text) return where;
  where.source = source->text;
  where.line = limited(line);
  where.column = limited(column);
  return where;
}

std::string Token::value() const {
  if (text.find('\\') == std::string_view::npos) return std::string(text);
  std::string out;
  out.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '\\') {
      out += text[i];
      continue;
    }
    switch (const char c = ++i < text.size() ? text[i] : '\0') {
    case 'b':
      out += '\b';
      break;
    case 'f':
      out += '\f';
      break;
    case 'n':
      out += '\n';
      break;
    case 'r':
      out += '\r';
      break;
    case 't':
      out += '\t';
      break;
    case '\\':
    case '\'':
    case '"':
      out += c;
      break;
    default: {
      Token place = *this;
      place.column += static_cast<int64_t>(i); // - 1 for the backslash, + 1 for the opening quote
      throw SceneError(place.location(), "unknown escape '\\" + printable({&c, 1}) + "' in a string",
                       "\\\" \\\\ \\' \\b \\f \\n \\r \\t; a backslash in a path is written \\\\");
    }
    }
  }
  return out;
}

std::string Token::shown() const {
  switch (kind) {
  case TokenKind::END:
    return "the end of the file";
  case TokenKind::OPEN:
    return "'['";
  case TokenKind::CLOSE:
    return "']'";
  case TokenKind::STRING:
    return "\"" + printable(text) + "\"";
  case TokenKind::WORD:
    break;
  }
  return "'" + printable(text) + "'";
}

bool looksLikeNumber(const Token& token) {
  return token.kind == TokenKind::WORD && looksLikeNumberText(token.text);
}

bool looksLikeNumberText(std::string_view t) {
  if (!t.empty() && (t[0] == '+' || t[0] == '-')) t.remove_prefix(1);
  if (t.empty()) return false;
  if (isDigit(t[0]) || t[0] == '.') return true;
  const std::string lower = lowerCase(std::string(t.substr(0, 8)));
  return lower == "nan" || lower == "inf" || lower == "infinity";
}

double numberValue(const Token& token) {
  double value = 0;
  const char* begin = token.text.data();
  const char* end = begin + token.text.size();
  if (token.kind == TokenKind::WORD && parseNumber(begin, end, value) == end) return value;
  if (looksLikeNumber(token)) {
    // Overflow of double, not finite, or not a number at all; underflow becomes zero.
    const std::string copy(token.text);
    char* stop = nullptr;
    value = std::strtod(copy.c_str(), &stop);
    const bool hexadecimal = copy.find_first_of("xX") != std::string::npos;
    if (stop == copy.c_str() + copy.size() && !hexadecimal) {
      if (std::isfinite(value)) return value;
      throw SceneError(token.location(), "the number " + token.shown() + " is not finite");
    }
  }
  throw SceneError(token.location(), "expected a number, found " + token.shown());
}

Lexer::Lexer(const Source& source) : from(&source) {
  const std::string& text = source.text->text;
  position = lineBegin = text.data();
  end = position + text.size();
  if (text.rfind("\xef\xbb\xbf", 0) == 0) position += 3; // a UTF-8 byte order mark
}

void Lexer::moveTo(size_t offset, int64_t newLine, int64_t column) {
  const std::string& text = from->text->text;
  position = text.data() + std::min(offset, text.size());
  line = newLine;
  lineBegin = position - (column - 1);
}

void Lexer::skipBlanks() {
  while (position < end) {
    const char c = *position;
    if (c == '\n') {
      ++position;
      ++line;
      lineBegin = position;
    } else if (isBlank(c)) {
      ++position;
    } else if (c == '#') {
      while (position < end && *position != '\n' && *position != '\r') ++position;
    } else {
      return;
    }
  }
}

Token Lexer::next() {
  skipBlanks();
  Token token;
  token.source = from;
  token.line = line;
  token.column = position - lineBegin + 1;
  if (position >= end) return token;
  const char* begin = position;
  if (*begin == '[' || *begin == ']') {
    token.kind = *begin == '[' ? TokenKind::OPEN : TokenKind::CLOSE;
    ++position;
    token.text = {begin, 1};
  } else if (*begin == '"') {
    token.kind = TokenKind::STRING;
    ++position;
    while (position < end && *position != '"' && *position != '\n') {
      if (*position == '\\' && position + 1 < end && position[1] != '\n') ++position;
      ++position;
    }
    token.text = {begin + 1, static_cast<size_t>(position - begin - 1)};
    if (position >= end || *position != '"')
      throw SceneError(token.location(), "this string has no closing quote on its line");
    ++position;
  } else {
    token.kind = TokenKind::WORD;
    while (position < end && !endsWord(*position)) ++position;
    token.text = {begin, static_cast<size_t>(position - begin)};
  }
  return token;
}

void Lexer::appendNumbers(std::vector<double>& out) {
  for (;;) {
    skipBlanks();
    double value;
    const char* stop = parseNumber(position, end, value);
    if (!stop) return;
    out.push_back(value);
    position = stop;
  }
}

} // namespace recurse::sceneFile
