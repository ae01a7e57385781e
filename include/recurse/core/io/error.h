/** @file
 * Errors: their location in a scene file, collections of several, and the exit status of each kind.
 */
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace recurse {

enum class ExitStatus { DONE = 0, FAILED = 1, BAD_USAGE = 2, BAD_SCENE = 3, INTERRUPTED = 130 };

/** Error that ends the program, or the present task, with a message for a person. */
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message, ExitStatus status = ExitStatus::FAILED)
      : std::runtime_error(message), exitStatus(status) {}
  ExitStatus status() const { return exitStatus; }

 private:
  ExitStatus exitStatus;
};

/** Text of one scene file, kept as long as a SourceLocation refers to it. */
struct SourceText {
  std::string name; ///< as a person would write it, for messages
  std::string text; ///< after decompression
};

/** Location in a scene file; without a source, the location of a default or of a command-line option. */
struct SourceLocation {
  std::shared_ptr<const SourceText> source;
  int line = 0;   ///< from 1; 0: the whole file
  int column = 0; ///< from 1, in bytes; 0: unknown
  /** The whole line of the location, without its end; empty without a source. */
  std::string lineText() const;
};

enum class Severity { ERROR, WARNING };

struct Diagnostic {
  Severity severity = Severity::ERROR;
  SourceLocation location;
  std::string message;  ///< the error or warning
  std::string accepted; ///< accepted values; may be empty

  /** Text `file:line:column: error: message`, the line with a caret, and the accepted values. */
  std::string format() const;
};

/** Collection of diagnostics, so that one run reports all errors. Messages of more than 600 bytes, and lists
 * of accepted values of more than 4000, lose their middle. */
class Diagnostics {
 public:
  void error(const SourceLocation& where, const std::string& message, const std::string& accepted = {});
  void warning(const SourceLocation& where, const std::string& message, const std::string& accepted = {});
  bool hasErrors() const { return errorCount > 0; }
  size_t errors() const { return errorCount; }
  const std::vector<Diagnostic>& all() const { return list; }
  /** All diagnostics in the order of reporting, on lines of their own; those that differ only in their
   * locations appear once, with the further locations. */
  std::string format() const;
  /** Throws a SceneError with all collected diagnostics when at least one of them is an error. */
  void throwIfErrors() const;

 private:
  std::vector<Diagnostic> list;
  size_t errorCount = 0;
};

/** Error in a scene that makes it unusable: what() is the formatted diagnostics. */
class SceneError : public Error {
 public:
  explicit SceneError(const std::string& message) : Error(message, ExitStatus::BAD_SCENE) {}
  SceneError(const SourceLocation& where, const std::string& message, const std::string& accepted = {});
  /** Locations and messages; may be empty. */
  const std::vector<Diagnostic>& diagnostics() const { return list; }

 private:
  friend class Diagnostics;
  std::vector<Diagnostic> list;
};

/** Up to `most` of `names`, regardless of case: ones that `wrong` misspells, nearest first, then longer ones
 * that contain it. */
std::vector<std::string> nearestNames(const std::string& wrong, const std::vector<std::string>& names,
                                      size_t most = 3);

} // namespace recurse
