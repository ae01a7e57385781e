/** @file
 * The tokens of a file with its includes spliced in: an Include may stand anywhere, even between the
 * parameters of a directive.
 */
#pragma once

#include <optional>
#include <vector>

#include "scene/errorLog.h"
#include "scene/sourceFiles.h"

namespace recurse::sceneFile {

/** Includes so far in the whole scene: files that include each other twice over grow without bound. */
struct IncludeCount {
  static constexpr int MAX_INCLUDES = 100000;
  static constexpr size_t MAX_DEPTH = 64;
  int count = 0;
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
  void include(const Token& directive);
  /** Goes on with the numbers of the track that `$name` stands for. Throws SceneError. */
  void spliceTrack(const Token& reference);
  void collectOpen(std::vector<const Source*>& chain) const;

  SourceFiles& files;
  ErrorLog& log;
  IncludeCount& includes;
  const TokenStream* outer;
  std::vector<Lexer> stack;
  std::optional<Token> ahead;
};

} // namespace recurse::sceneFile
