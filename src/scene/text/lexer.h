/** @file
 * Tokens of one scene-file text. Strings are cut out without copying, and runs of numbers go straight into a
 * vector, because meshes written as text are most of what a big scene file holds.
 */
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "recurse/core/io/error.h"

namespace recurse::sceneFile {

/** A text with what its reader needs to know: shared by every token and place in it. */
struct Source {
  std::shared_ptr<const SourceText> text;
  std::string directory; ///< that file names inside the text are relative to
  std::string canonical; ///< path that tells files apart; empty for text that is not a file
};

enum class TokenKind { END, WORD, STRING, OPEN, CLOSE };

struct Token {
  TokenKind kind = TokenKind::END;
  std::string_view text; ///< of a string: what stands between the quotes, escapes not yet decoded
  const Source* source = nullptr;
  int64_t line = 0, column = 0;

  SourceLocation location() const;
  /** The value of a string, with its escapes decoded. Throws SceneError for an escape that does not exist. */
  std::string value() const;
  /** For messages: the token as it is written, shortened. */
  std::string shown() const;
  bool isWord(std::string_view word) const { return kind == TokenKind::WORD && text == word; }
};

/** The value of a word that is a number. Throws SceneError where it is none, or not finite. */
double numberValue(const Token& token);
/** True for words that are meant as a number: they begin like one, or say nan or inf. */
bool looksLikeNumber(const Token& token);
bool looksLikeNumberText(std::string_view text);

class Lexer {
 public:
  /** `source` must outlive the lexer and its tokens. */
  explicit Lexer(const Source& source);

  /** The next token; END for ever after the last. Throws SceneError for a string without end. */
  Token next();
  /** Appends plain numbers up to the first token that is not one. */
  void appendNumbers(std::vector<double>& out);

  /** Goes on reading at this byte, which stands in this place. */
  void moveTo(size_t offset, int64_t newLine, int64_t column);

  const Source& source() const { return *from; }

 private:
  void skipBlanks();

  const Source* from;
  const char *position, *end, *lineBegin;
  int64_t line = 1;
};

} // namespace recurse::sceneFile
