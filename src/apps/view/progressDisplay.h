/** @file
 * Progress of a render on standard error: a line that is rewritten, plain lines, or JSON.
 */
#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "recurse/render/render.h"

namespace recurse::apps {

enum class ProgressMode { TERMINAL, PLAIN, JSON, OFF };

/** Mode by name. "auto" is TERMINAL if standard error is a terminal, else PLAIN. */
ProgressMode progressModeOf(const std::string& name);

class ProgressDisplay {
 public:
  explicit ProgressDisplay(ProgressMode mode) : mode(mode) {}
  ~ProgressDisplay() { finish(); }
  void update(const RenderProgress& progress);
  /** Prints a line without disturbing the progress line. */
  void message(const std::string& text);
  /** Removes the progress line. */
  void finish();

 private:
  void clear();

  const ProgressMode mode;
  std::mutex mutex;
  bool shown = false; ///< the terminal shows a progress line
  std::string lastPhase;
  double lastFraction = 0;
  std::chrono::steady_clock::time_point last{};
};

} // namespace recurse::apps
