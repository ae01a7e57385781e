/** @file
 * Diagnostics with a limit, so that a file that is not a scene does not fill the screen.
 */
#pragma once

#include "recurse/core/io/error.h"

namespace recurse::sceneFile {

/** Thrown to stop the parsing of a scene after too many errors. */
struct TooManyErrors {};

class ErrorLog {
 public:
  static constexpr int MAX_ERRORS = 50;
  static constexpr int MAX_WARNINGS = 50;

  explicit ErrorLog(Diagnostics& diagnostics) : out(diagnostics) {}

  void error(const SourceLocation& where, const std::string& message, const std::string& accepted = {}) {
    out.error(where, message, accepted);
    if (++errors < MAX_ERRORS) return;
    out.warning({}, "further errors are not shown");
    throw TooManyErrors();
  }
  void warning(const SourceLocation& where, const std::string& message, const std::string& accepted = {}) {
    if (++warnings < MAX_WARNINGS) out.warning(where, message, accepted);
    if (warnings == MAX_WARNINGS) out.warning({}, "further warnings of the scene file are not shown");
  }
  /** True after a parameter type that only pbrt-v3 knew. */
  bool sawPbrt3Type = false;

  void report(const SceneError& e) {
    for (const Diagnostic& d : e.diagnostics()) error(d.location, d.message, d.accepted);
    if (e.diagnostics().empty()) error({}, e.what());
  }

 private:
  Diagnostics& out;
  int errors = 0, warnings = 0;
};

/** "file:line" of a location, for mention in a message about a different one. */
inline std::string placeName(const SourceLocation& where) {
  return (where.source ? where.source->name : std::string("?")) + ":" + std::to_string(where.line);
}

} // namespace recurse::sceneFile
