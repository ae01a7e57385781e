/** @file
 * Tokens of one scene-file text. Strings are views without a copy, and sequences of numbers are appended
 * directly to a vector, because most of a large scene file consists of meshes in text form.
 */
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "recurse/core/io/error.h"

namespace recurse::sceneFile {

/** Text with the context of its reader, shared by all its tokens and locations. */
struct Source {
  std::shared_ptr<const SourceText> text;
  std::string directory; ///< base of relative file names in the text
  std::string canonical; ///< identifies a file; empty for text that is not a file
};

enum class TokenKind { END, WORD, STRING, OPEN, CLOSE };

struct Token {
  TokenKind kind = TokenKind::END;
  std::string_view text; ///< of a string: the text between the quotes, with undecoded escapes
  const Source* source = nullptr;
  int64_t line = 0, column = 0;

  SourceLocation location() const;
  /** Value of a string, with its escapes decoded. Throws SceneError for an unknown escape. */
  std::string value() const;
  /** The token as written, shortened for messages. */
  std::string shown() const;
  bool isWord(std::string_view word) const { return kind == TokenKind::WORD && text == word; }
};

/** Value of a word that is a number. Throws SceneError where it is none, or not finite. */
double numberValue(const Token& token);
/** True for words intended as a number: they begin like one, or are nan or inf. */
bool looksLikeNumber(const Token& token);
bool looksLikeNumberText(std::string_view text);

class Lexer {
 public:
  /** `source` must outlive the lexer and its tokens. */
  explicit Lexer(const Source& source);

  /** The next token; END after the last one, repeatedly. Throws SceneError for an unterminated string. */
  Token next();
  /** Appends plain numbers up to the first token that is not a number. */
  void appendNumbers(std::vector<double>& out);

  /** Continues at this byte offset, with the given line and column. */
  void moveTo(size_t offset, int64_t newLine, int64_t column);

  const Source& source() const { return *from; }

 private:
  void skipBlanks();

  const Source* from;
  const char *position, *end, *lineBegin;
  int64_t line = 1;
};

} // namespace recurse::sceneFile
