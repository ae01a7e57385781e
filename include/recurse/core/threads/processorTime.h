/** @file
 * Processor time of the process, and elapsed time.
 */
#pragma once

#include <chrono>
#include <ctime>

namespace recurse {

/** Processor time that all threads of the process have used [s]. */
inline double processorSeconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

/** Elapsed time since `start` [s]. */
inline double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/** Adds the processor time of the whole process during its lifetime to a sum [s]. */
class ProcessorTimer {
 public:
  explicit ProcessorTimer(double& sum) : sum(sum) {}
  ~ProcessorTimer() { sum += processorSeconds() - start; }
  ProcessorTimer(const ProcessorTimer&) = delete;
  ProcessorTimer& operator=(const ProcessorTimer&) = delete;

 private:
  double& sum;
  double start = processorSeconds();
};

} // namespace recurse
