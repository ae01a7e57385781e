/** @file
 * Parallel loops whose results do not depend on the number of threads, and the threads' floating-point mode.
 */
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace recurse {

/** Sets flush-to-zero and denormals-are-zero on the calling thread. */
void setThreadFloatMode();

/**
 * Worker threads, during the lifetime of the pool: at most `threads` of them, including the thread that calls
 * parallelFor() (0: one for each core that this process may use), each with the float mode above. Create one
 * at a time.
 */
class ThreadPool {
 public:
  explicit ThreadPool(int threads = 0);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts;
};

/** Number of cores that this process may run on. */
int availableCores();
/** Maximum number of threads of a parallel loop. */
int threadCount();

/** Calls body(i) for 0 <= i < count, in any order, on the threads of the pool, and returns when all are done.
 * Without a pool it uses all cores. Each i may write only to data of its own. Throws Interrupted, see
 * checkInterrupted(), or the first exception of `body`; iterations that have not begun are then skipped. */
void parallelFor(size_t count, const std::function<void(size_t)>& body);

} // namespace recurse
