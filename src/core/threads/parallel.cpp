/** @file
 * Parallel loops by TBB.
 */
#include "recurse/core/threads/parallel.h"

#include <thread>

#include <sched.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_scheduler_observer.h>

#include "recurse/core/math/float8.h"
#include "recurse/core/threads/interrupt.h"

namespace recurse {

void setThreadFloatMode() { flushDenormals(); }

int availableCores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) return std::max(1, CPU_COUNT(&set));
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

namespace {

class FloatModeObserver : public tbb::task_scheduler_observer {
 public:
  FloatModeObserver() { observe(true); }
  ~FloatModeObserver() override { observe(false); }
  void on_scheduler_entry(bool) override { setThreadFloatMode(); }
};

} // namespace

struct ThreadPool::Parts {
  explicit Parts(int threads)
      : control(tbb::global_control::max_allowed_parallelism,
                static_cast<size_t>(threads > 0 ? threads : availableCores())) {}
  tbb::global_control control;
  FloatModeObserver observer;
};

ThreadPool::ThreadPool(int threads) : parts(std::make_unique<Parts>(threads)) { setThreadFloatMode(); }
ThreadPool::~ThreadPool() = default;

int threadCount() {
  return static_cast<int>(
      std::min(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism),
               static_cast<size_t>(tbb::this_task_arena::max_concurrency())));
}

void parallelFor(size_t count, const std::function<void(size_t)>& body) {
  // TBB gives its tasks the float mode of the thread that used it first, which may be another.
  const auto inFloatMode = [&](size_t i) {
    setThreadFloatMode();
    body(i);
  };
  const std::atomic<bool>* const flag = InterruptibleWork::flag();
  if (!flag) return tbb::parallel_for(size_t{0}, count, inFloatMode, tbb::simple_partitioner());
  const auto unlessInterrupted = [&](size_t i) {
    const InterruptibleWork iteration(flag);
    checkInterrupted();
    inFloatMode(i);
  };
  tbb::parallel_for(size_t{0}, count, unlessInterrupted, tbb::simple_partitioner());
}

} // namespace recurse
