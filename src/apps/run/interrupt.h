/** @file
 * Ctrl-C and its relatives: what is there is written first; a second one ends the program at once.
 */
#pragma once

#include <atomic>
#include <optional>
#include <thread>

#include "recurse/core/threads/interrupt.h"

namespace recurse::apps {

/** Installs the handlers of SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGXCPU and SIGPIPE. Until a GracefulStop
 * exists a signal ends the program at once, with exit status 130 (SIGPIPE: as if there were no handler) and
 * without temporary files left behind. A file above the limit of size is an error of that file alone. */
void installInterruptHandlers();

/** Does what the first signal does where a GracefulStop lives. */
void requestStop();
/** Takes requestStop() back. */
void withdrawStop();

/** While one lives, there is nothing to be written: a signal ends the program at once. */
class NothingToWrite {
 public:
  /** What the time limit ends. */
  enum class TimeLimit {
    PROGRAM, ///< at once, with a message
    WORK     ///< of this thread, by checkInterrupted(), as it does where a stop is requested
  };
  /** `seconds`: the time limit; 0: there is none. */
  explicit NothingToWrite(double seconds, TimeLimit limited = TimeLimit::PROGRAM);
  ~NothingToWrite();
  NothingToWrite(const NothingToWrite&) = delete;
  NothingToWrite& operator=(const NothingToWrite&) = delete;

  bool timeIsUp() const { return isUp; }

 private:
  std::atomic<bool> isUp{false}, ends{false};
  std::optional<InterruptibleWork> work;
  std::jthread clock;
};
/** Says that the time limit was up before a scene was loaded. */
extern const char* const NOT_LOADED_IN_TIME;

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
