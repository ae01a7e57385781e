/** @file
 * Thread that polls a condition while others work.
 */
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

#include "recurse/core/threads/interrupt.h"

namespace recurse {

/** Calls `look`, which must not throw, every 20 ms in a thread of its own, from its construction to its
 * destruction. */
class Watchdog {
 public:
  explicit Watchdog(std::function<void()> look)
      : look(std::move(look)), thread([this](const std::stop_token& done) { watch(done); }) {}

 private:
  void watch(const std::stop_token& done) {
    std::mutex own;
    std::unique_lock<std::mutex> lock(own);
    std::condition_variable_any sleep;
    while (!done.stop_requested()) {
      look();
      sleep.wait_for(lock, done, std::chrono::milliseconds(20), [] { return false; });
    }
  }
  std::function<void()> look;
  std::jthread thread;
};

/** Result of work(), in which checkInterrupted() throws soon after isToEnd(), called from another thread,
 * becomes true; isToEnd() must not throw. A flag of an InterruptibleWork around it has no effect inside. */
template <class Work> auto interruptibly(const std::function<bool()>& isToEnd, const Work& work) {
  std::atomic<bool> isEnding{false};
  const Watchdog watchdog([&] {
    if (isToEnd()) isEnding = true;
  });
  const InterruptibleWork interruptible(&isEnding);
  return work();
}

} // namespace recurse
