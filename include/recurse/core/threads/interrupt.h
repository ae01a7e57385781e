/** @file
 * Work that is given up in the middle, on all threads: learning and photons, which a render may do without.
 */
#pragma once

#include <atomic>
#include <utility>

#include "recurse/core/io/error.h"

namespace recurse {

/** Thrown by checkInterrupted(). */
class Interrupted : public Error {
 public:
  Interrupted();
};

/** While one lives, checkInterrupted() asks its flag on this thread, and on others for the iterations of
 * loops of parallelFor() that begin here. Null: it asks nothing. */
class InterruptibleWork {
 public:
  explicit InterruptibleWork(const std::atomic<bool>* flag) : before(std::exchange(flagOfThread, flag)) {}
  ~InterruptibleWork() { flagOfThread = before; }
  InterruptibleWork(const InterruptibleWork&) = delete;
  InterruptibleWork& operator=(const InterruptibleWork&) = delete;

  /** The flag that this thread asks; null: none. */
  static const std::atomic<bool>* flag() { return flagOfThread; }

 private:
  static inline thread_local const std::atomic<bool>* flagOfThread = nullptr;
  const std::atomic<bool>* const before;
};

/** Throws Interrupted where the flag of an InterruptibleWork is set. Scenes ask before each ray, and
 * parallelFor() before each iteration. */
inline void checkInterrupted() {
  const std::atomic<bool>* flag = InterruptibleWork::flag();
  if (flag && flag->load(std::memory_order_relaxed)) throw Interrupted();
}

} // namespace recurse
