/** @file
 * Ctrl-C and its relatives: what is there is written first; a second one ends the program at once.
 */
#pragma once

#include <atomic>
#include <thread>

namespace recurse::apps {

/** Installs the handlers of SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGXCPU and SIGPIPE. Until a GracefulStop
 * exists a signal ends the program at once, with exit status 130 (SIGPIPE: as if there were no handler) and
 * without temporary files left behind. A file above the limit of size is an error of that file alone. */
void installInterruptHandlers();

/** Does what the first signal does where a GracefulStop lives. */
void requestStop();
/** Takes requestStop() back. */
void withdrawStop();

/** While one lives, there is nothing to be written: a signal ends the program at once, and so does the end of
 * the time limit [s]; 0: there is none. */
class NothingToWrite {
 public:
  explicit NothingToWrite(double timeLimit);
  ~NothingToWrite();
  NothingToWrite(const NothingToWrite&) = delete;
  NothingToWrite& operator=(const NothingToWrite&) = delete;

 private:
  std::jthread clock;
};

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
