/** @file
 * Ctrl-C: what is there is written first; a second one ends the program at once.
 */
#pragma once

#include <atomic>

namespace recurse::apps {

/** Installs the handlers of SIGINT, SIGTERM and SIGHUP. Until a GracefulStop exists a signal ends the program
 * at once, with exit status 130 and without temporary files left behind. */
void installInterruptHandlers();

/** Does what the first signal does where a GracefulStop lives. */
void requestStop();
/** Takes requestStop() back. */
void withdrawStop();

/** While one lives, the first signal only sets the flag. */
class GracefulStop {
 public:
  GracefulStop();
  ~GracefulStop();
  GracefulStop(const GracefulStop&) = delete;
  GracefulStop& operator=(const GracefulStop&) = delete;
  const std::atomic<bool>& flag() const;
};

} // namespace recurse::apps
