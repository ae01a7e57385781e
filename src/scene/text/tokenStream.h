/** @file
 * Token stream of a file with its includes spliced in: an Include is permitted everywhere, even between the
 * parameters of a directive.
 */
#pragma once

#include <optional>
#include <vector>

#include "scene/text/errorLog.h"
#include "scene/text/sourceFiles.h"

namespace recurse::sceneFile {

/** Total size of included text; files that include each other repeatedly would grow without bound. */
struct IncludeCount {
  static constexpr size_t MAX_BYTES = size_t(64) << 30;
  static constexpr size_t MIN_FILE_BYTES = size_t(64) << 10; ///< minimum counted for each file
  static constexpr size_t MAX_DEPTH = 64;
  size_t bytes = 0;
};

class TokenStream {
 public:
  /** `outer` is the importing stream, whose open files count for depth and recursion. */
  TokenStream(const Source& source, SourceFiles& files, ErrorLog& log, IncludeCount& includes,
              const TokenStream* outer = nullptr);

  const Token& peek();
  Token take();
  /** Appends the plain numbers at the current position. */
  void appendNumbers(std::vector<double>& out);
  /**
   * Source of the file requested by a directive, or null after an error was reported. `name` is the token of
   * its file name.
   */
  const Source* resolve(const Token& name, const char* directive);

 private:
  /** Open text, with the `$name` token that it replaces, if any. */
  struct Open {
    Lexer lexer;
    std::optional<Token> reference;
  };

  Token next();
  void include(const Token& directive);
  /** Continues with the values of the track of a `$name` token. Throws SceneError. */
  void spliceTrack(const Token& reference);
  /** Substitutes the values of tracks in a string. Throws SceneError. */
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
