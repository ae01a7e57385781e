/** @file
 * Signal handlers, restricted to async-signal-safe calls.
 */
#include "apps/run/interrupt.h"

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstring>
#include <mutex>

#include <unistd.h>

#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/error.h"

namespace recurse::apps {

namespace {

std::atomic<bool> stopRequested{false};
std::atomic<int> graceful{0};  // number of GracefulStop objects
std::atomic<int> immediate{0}; // number of NothingToWrite objects
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

void writeText(const char* text) {
  const ssize_t written = ::write(STDERR_FILENO, text, std::strlen(text));
  static_cast<void>(written); // nothing could be done about it here
}

/** True for signals that the system repeats: a second one is no request of the user. */
bool isRepeatedBySystem(int signal) { return signal == SIGXCPU || signal == SIGPIPE; }

void handle(int signal) {
  if (graceful.load() > 0 && immediate.load() == 0) {
    const bool isFirst = !stopRequested.exchange(true);
    if (isFirst)
      writeText("\n"
                "Interrupted: writing the picture of the samples so far. Press Ctrl-C again to "
                "quit without it.\n");
    if (isFirst || isRepeatedBySystem(signal)) return;
  }
  removeTemporaryFiles();
  if (signal == SIGPIPE) { // ends the program as the reader of the pipe expects
    ::signal(SIGPIPE, SIG_DFL);
    ::raise(SIGPIPE);
    return;
  }
  writeText("\nInterrupted.\n");
  ::_exit(static_cast<int>(ExitStatus::INTERRUPTED));
}

/** Installs a handler, unless the program's parent has the signal ignored, as nohup does. */
void installUnlessIgnored(int signal, const struct sigaction& action) {
  struct sigaction before {};
  if (::sigaction(signal, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
    ::sigaction(signal, &action, nullptr);
}

} // namespace

void installInterruptHandlers() {
  struct sigaction action {};
  action.sa_handler = handle;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  ::sigaction(SIGUSR1, &action, nullptr); // sent by schedulers before the time is up; mpirun passes it on
  ::sigaction(SIGXCPU, &action, nullptr);
  installUnlessIgnored(SIGHUP, action);
  installUnlessIgnored(SIGPIPE, action);
  ::signal(SIGXFSZ, SIG_IGN); // writing fails instead
}

void requestStop() { stopRequested = true; }
void withdrawStop() { stopRequested = false; }

const char* const NOT_LOADED_IN_TIME =
    "the time limit ended before the scene was loaded: nothing was written. Give it a longer --time-limit.";

NothingToWrite::NothingToWrite(double seconds, TimeLimit limited) {
  ++immediate;
  if (limited == TimeLimit::WORK)
    work.emplace(&ends);
  else if (!(seconds > 0))
    return;
  clock = std::jthread([this, seconds, limited](const std::stop_token& done) {
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::milliseconds LOOK{20};
    const auto start = Clock::now();
    std::mutex own;
    std::unique_lock<std::mutex> lock(own);
    std::condition_variable_any sleep;
    while (!isUp) {
      sleep.wait_for(lock, done, LOOK, [] { return false; });
      if (done.stop_requested()) return;
      if (stopRequested) ends = true;
      isUp = seconds > 0 && std::chrono::duration<double>(Clock::now() - start).count() > seconds;
    }
    ends = true;
    if (limited == TimeLimit::WORK) return;
    removeTemporaryFiles();
    writeText("recurse: ");
    writeText(NOT_LOADED_IN_TIME);
    writeText("\n");
    ::_exit(static_cast<int>(ExitStatus::FAILED));
  });
}
NothingToWrite::~NothingToWrite() { --immediate; }

GracefulStop::GracefulStop() { ++graceful; }
GracefulStop::~GracefulStop() { --graceful; }
const std::atomic<bool>& GracefulStop::flag() const { return stopRequested; }

} // namespace recurse::apps
