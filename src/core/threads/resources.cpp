/** @file
 * Available memory according to Linux, the control groups, and the limits set in the shell.
 */
#include "recurse/core/threads/resources.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <utility>

#include <sys/resource.h>

#include "core/threads/controlGroup.h"
#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"

namespace recurse {

namespace {

double memoryLimit = INFINITY; // of the process [bytes]
double workLimit = INFINITY;   // of a scene [s]
thread_local WorkSum* sumOfThread = nullptr;

/** Number after a word in a file of "Name: number kB" lines [bytes]; infinite where the word is missing. */
double numberAfter(const char* fileName, const std::string& word) {
  std::ifstream in(fileName);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(word)) return std::atof(line.c_str() + word.size()) * 1024;
  return INFINITY;
}

double limitOfAddresses() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return INFINITY;
  return double(limit.rlim_cur) - numberAfter("/proc/self/status", "VmSize:");
}

} // namespace

void setMemoryLimit(double bytes) { memoryLimit = bytes; }

double availableMemory() {
  const double left = memoryLimit < INFINITY ? memoryLimit - numberAfter("/proc/self/status", "VmRSS:")
                                             : numberAfter("/proc/meminfo", "MemAvailable:");
  return std::max(0.0, std::min({left, detail::memoryLeftByGroups(), limitOfAddresses()}));
}

void requireMemory(const std::string& subject, double bytes) {
  constexpr double SMALL = 0x1p26; // [bytes] below it, the query takes as long as the work itself
  if (bytes <= SMALL) return;
  const double available = availableMemory();
  if (bytes <= available) return;
  throw Error(
      subject +
      formatted(" needs about %.3g GB of memory, and %.3g GB are available", bytes / 1e9, available / 1e9) +
      (memoryLimit < INFINITY ? " (--memory)" : ""));
}

void setWorkLimit(double seconds) { workLimit = seconds; }

void requireWork(const std::string& subject, double seconds) {
  const double before = sumOfThread ? sumOfThread->sum : 0, sum = before + seconds;
  if (sum > workLimit) {
    const std::string others =
        before > 0 ? formatted(" after %.3g s for other parts of the scene", before) : "";
    throw Error(subject + formatted(" takes about %.3g s of one core", seconds) + others +
                formatted(", and %.3g s are allowed (--work)", workLimit));
  }
  if (sumOfThread) sumOfThread->sum = sum;
}

WorkSum::WorkSum() : outer(std::exchange(sumOfThread, this)) {}
WorkSum::~WorkSum() { sumOfThread = outer; }

MemoryCap::MemoryCap(double bytes) : limit(numberAfter("/proc/self/status", "VmData:") + bytes) {
  rlimit before{};
  outer = ::getrlimit(RLIMIT_DATA, &before) == 0 ? before.rlim_cur : RLIM_INFINITY;
  apply();
}

MemoryCap::~MemoryCap() {
  limit = INFINITY;
  apply();
}

void MemoryCap::raise(double bytes) {
  limit += bytes;
  apply();
}

void MemoryCap::apply() const {
  rlimit now{};
  if (::getrlimit(RLIMIT_DATA, &now) != 0) return;
  now.rlim_cur = limit < double(outer) ? static_cast<rlim_t>(limit) : static_cast<rlim_t>(outer);
  ::setrlimit(RLIMIT_DATA, &now);
}

} // namespace recurse
