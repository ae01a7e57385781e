/** @file
 * Signal handlers, with nothing in them that a handler must not do.
 */
#include "apps/interrupt.h"

#include <csignal>
#include <cstring>

#include <unistd.h>

#include "recurse/core/atomicFile.h"
#include "recurse/core/error.h"

namespace recurse::apps {

namespace {

std::atomic<bool> stopRequested{false};
std::atomic<int> graceful{0}; // how many GracefulStops there are
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

void say(const char* text) {
  const ssize_t written = ::write(STDERR_FILENO, text, std::strlen(text));
  static_cast<void>(written); // nothing could be done about it here
}

void handle(int) {
  if (graceful.load() > 0 && !stopRequested.exchange(true)) {
    say("\nInterrupted: writing what there is. Once more gives up at once.\n");
    return;
  }
  removeTemporaryFiles();
  say("\nInterrupted.\n");
  ::_exit(static_cast<int>(ExitStatus::INTERRUPTED));
}

} // namespace

void installInterruptHandlers() {
  struct sigaction action {};
  action.sa_handler = handle;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  ::sigaction(SIGUSR1, &action, nullptr); // of schedulers, before the time is up; mpirun passes it on at once
  struct sigaction before {};
  // nohup asks for SIGHUP to be ignored, and is obeyed.
  if (::sigaction(SIGHUP, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
    ::sigaction(SIGHUP, &action, nullptr);
}

void requestStop() { stopRequested = true; }
void withdrawStop() { stopRequested = false; }

GracefulStop::GracefulStop() { ++graceful; }
GracefulStop::~GracefulStop() { --graceful; }
const std::atomic<bool>& GracefulStop::flag() const { return stopRequested; }

} // namespace recurse::apps
