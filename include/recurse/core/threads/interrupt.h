/** @file
 * Work on all threads that can end early: reading and building scenes, learning, photons, camera paths.
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

/** Scope in which checkInterrupted() reads the given flag, on this thread and in the iterations of
 * parallelFor() loops that begin here. Null: no flag. */
class InterruptibleWork {
 public:
  explicit InterruptibleWork(const std::atomic<bool>* flag) : before(std::exchange(flagOfThread, flag)) {}
  ~InterruptibleWork() { flagOfThread = before; }
  InterruptibleWork(const InterruptibleWork&) = delete;
  InterruptibleWork& operator=(const InterruptibleWork&) = delete;

  /** The flag that checkInterrupted() reads on this thread; null: none. */
  static const std::atomic<bool>* flag() { return flagOfThread; }

 private:
  static inline thread_local const std::atomic<bool>* flagOfThread = nullptr;
  const std::atomic<bool>* const before;
};

/** Throws Interrupted where the flag of an InterruptibleWork is set. Scenes call it before each ray or packet
 * of rays, parallelFor() before each iteration. */
inline void checkInterrupted() {
  const std::atomic<bool>* flag = InterruptibleWork::flag();
  if (flag && flag->load(std::memory_order_relaxed)) throw Interrupted();
}

} // namespace recurse
