/** @file
 * Errors: where they are in a scene file, several at a time, and the exit status that each kind leads to.
 */
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace recurse {

enum class ExitStatus { DONE = 0, FAILED = 1, BAD_USAGE = 2, BAD_SCENE = 3, INTERRUPTED = 130 };

/** Something that ends the program, or the present task, with a message for a person. */
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message, ExitStatus status = ExitStatus::FAILED)
      : std::runtime_error(message), exitStatus(status) {}
  ExitStatus status() const { return exitStatus; }

 private:
  ExitStatus exitStatus;
};

/** The text of one scene file, kept while places in it may still be pointed at. */
struct SourceText {
  std::string name; ///< as a person would write it
  std::string text; ///< after decompression
};

/** A place in a scene file; without a file, a place that nobody wrote (a default, an option). */
struct SourceLocation {
  std::shared_ptr<const SourceText> source;
  int line = 0;   ///< from 1
  int column = 0; ///< from 1, in bytes
  /** The whole line pointed at, without its end; empty where there is none. */
  std::string lineText() const;
};

enum class Severity { ERROR, WARNING };

struct Diagnostic {
  Severity severity = Severity::ERROR;
  SourceLocation location;
  std::string message;  ///< what is wrong
  std::string accepted; ///< what would be accepted; may be empty

  /** `file:line:column: error: message`, the line with a caret, and what would be accepted. */
  std::string format() const;
};

/** Diagnostics are collected, so that one run tells all that is wrong. */
class Diagnostics {
 public:
  void error(const SourceLocation& where, const std::string& message, const std::string& accepted = {});
  void warning(const SourceLocation& where, const std::string& message, const std::string& accepted = {});
  bool hasErrors() const { return errorCount > 0; }
  size_t errors() const { return errorCount; }
  const std::vector<Diagnostic>& all() const { return list; }
  /** Every diagnostic in the order of reporting, each on lines of its own. */
  std::string format() const;
  /** Throws a SceneError with everything collected when there is at least one error. */
  void throwIfErrors() const;

 private:
  std::vector<Diagnostic> list;
  size_t errorCount = 0;
};

/** A scene that cannot be used: what() is the formatted diagnostics. */
class SceneError : public Error {
 public:
  explicit SceneError(const std::string& message) : Error(message, ExitStatus::BAD_SCENE) {}
  SceneError(const SourceLocation& where, const std::string& message, const std::string& accepted = {});
  /** The places and messages, where the error carries some. */
  const std::vector<Diagnostic>& diagnostics() const { return list; }

 private:
  friend class Diagnostics;
  std::vector<Diagnostic> list;
};

/** Up to `most` of `names`: those that `wrong` misspells, nearest first, then longer ones that contain it. */
std::vector<std::string> nearestNames(const std::string& wrong, const std::vector<std::string>& names,
                                      size_t most = 3);

} // namespace recurse
