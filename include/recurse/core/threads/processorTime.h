/** @file
 * Processor time of the process.
 */
#pragma once

#include <ctime>

namespace recurse {

/** Processor time that all threads of the process have used [s]. */
inline double processorSeconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

/** Adds the processor time of its lifetime to a sum [s]. */
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
