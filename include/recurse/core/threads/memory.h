/** @file
 * How much memory there is, asked before much of it is taken: a process that takes too much is killed
 * without a word.
 */
#pragma once

#include <string>

namespace recurse {

/** The process is to take no more than this [bytes] in all. */
void setMemoryLimit(double bytes);

/** What the process can take [bytes]: what the limit leaves, or without one what there is without swapping;
 * infinite where the system does not say. */
double availableMemory();

/** Throws Error, which begins with `subject`, when that much memory is not available. */
void requireMemory(const std::string& subject, double bytes);

/** While one lives, memory beyond what the process had at its beginning is refused (std::bad_alloc): for
 * work whose needs nobody can tell, such as that of other libraries. They may be nested. */
class MemoryCap {
 public:
  explicit MemoryCap(double bytes);
  ~MemoryCap();
  MemoryCap(const MemoryCap&) = delete;
  MemoryCap& operator=(const MemoryCap&) = delete;
  /** Allows for more [bytes]. */
  void raise(double bytes);

 private:
  void apply() const;

  double limit;             ///< of the process's data [bytes]
  unsigned long long outer; ///< the limit before
};

} // namespace recurse
