/** @file
 * The tokens of a file with its includes spliced in: an Include may stand anywhere, even between the
 * parameters of a directive.
 */
#pragma once

#include <optional>
#include <vector>

#include "scene/text/errorLog.h"
#include "scene/text/sourceFiles.h"

namespace recurse::sceneFile {

/** Text that is included in the whole scene: files that include each other twice over grow without bound. */
struct IncludeCount {
  static constexpr size_t MAX_BYTES = size_t(64) << 30;
  static constexpr size_t MIN_FILE_BYTES = size_t(64) << 10; ///< that each file counts for
  static constexpr size_t MAX_DEPTH = 64;
  size_t bytes = 0;
};

class TokenStream {
 public:
  /** `outer` is the stream that imports this one; its open files count for depth and recursion. */
  TokenStream(const Source& source, SourceFiles& files, ErrorLog& log, IncludeCount& includes,
              const TokenStream* outer = nullptr);

  const Token& peek();
  Token take();
  /** Appends the plain numbers that come next. */
  void appendNumbers(std::vector<double>& out);
  /**
   * The source of the file that a directive asks for, or null after reporting why it cannot be had. `name` is
   * the token with its file name.
   */
  const Source* resolve(const Token& name, const char* directive);

 private:
  /** An open text, and where `$name` stands in whose place it is read. */
  struct Open {
    Lexer lexer;
    std::optional<Token> reference;
  };

  Token next();
  void include(const Token& directive);
  /** Goes on with the numbers of the track that `$name` stands for. Throws SceneError. */
  void spliceTrack(const Token& reference);
  /** Writes the numbers of tracks into a string. Throws SceneError. */
  void insertTracks(Token& string);
  void collectOpen(std::vector<const Source*>& chain) const;

  SourceFiles& files;
  ErrorLog& log;
  IncludeCount& includes;
  const TokenStream* outer;
  std::vector<Open> stack;
  std::optional<Token> ahead;
};

} // namespace recurse::sceneFile
