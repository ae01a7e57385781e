/** @file
 * Ctrl-C and similar signals: the first one leads to output of results, a second one ends the program.
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

/** Sets the flag of GracefulStop, like the first signal. */
void requestStop();
/** Clears the flag of GracefulStop. */
void withdrawStop();

/** During its lifetime, there are no results to be written: a signal ends the program at once. */
class NothingToWrite {
 public:
  /** Extent of the time limit. */
  enum class TimeLimit {
    PROGRAM, ///< ends at once, with a message
    WORK     ///< ends work of this thread, by checkInterrupted(), like a requested stop
  };
  /** `seconds`: time limit; 0: none. */
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
/** Message that the time limit was up before a scene was loaded. */
extern const char* const NOT_LOADED_IN_TIME;

/** During its lifetime, the first signal only sets the flag. */
class GracefulStop {
 public:
  GracefulStop();
  ~GracefulStop();
  GracefulStop(const GracefulStop&) = delete;
  GracefulStop& operator=(const GracefulStop&) = delete;
  const std::atomic<bool>& flag() const;
};

} // namespace recurse::apps
