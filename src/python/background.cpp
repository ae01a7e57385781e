/** @file
 * Background thread, and a wait with interruptions.
 */
#include "python/background.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include <pybind11/pybind11.h>

#include "recurse/core/threads/interrupt.h"

namespace recurse::python {

void runInBackground(const std::function<void()>& work, const std::function<void()>& look,
                     const std::function<void()>& stop) {
  constexpr std::chrono::milliseconds PERIOD(100);
  std::mutex mutex;
  std::condition_variable ended;
  bool done = false;
  std::atomic<bool> isInterrupted{false};
  std::exception_ptr failure, interruption;
  const auto attempt = [](const std::function<void()>& part, std::exception_ptr& caught) {
    try {
      part();
    } catch (...) {
      caught = std::current_exception();
    }
  };
  {
    const pybind11::gil_scoped_release others;
    std::thread worker([&] {
      const InterruptibleWork interruptible(&isInterrupted);
      attempt(work, failure);
      const std::lock_guard guard(mutex);
      done = true;
      ended.notify_one();
    });
    std::unique_lock lock(mutex);
    while (!ended.wait_for(lock, PERIOD, [&] { return done; })) {
      lock.unlock();
      if (!interruption) {
        const pybind11::gil_scoped_acquire python;
        attempt(
            [&] {
              if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
              look();
            },
            interruption);
        if (interruption) {
          isInterrupted = true;
          stop();
        }
      }
      lock.lock();
    }
    lock.unlock();
    worker.join();
  }
  if (interruption) std::rethrow_exception(interruption);
  if (failure) std::rethrow_exception(failure);
}

} // namespace recurse::python
