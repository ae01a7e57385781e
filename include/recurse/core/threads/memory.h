/** @file
 * Available memory, checked before large allocations: a process that takes too much is killed without a
 * message.
 */
#pragma once

#include <string>

namespace recurse {

/** Sets the memory that the process may take in all [bytes]. */
void setMemoryLimit(double bytes);

/** Memory that the process can still take [bytes]: the remainder of the limit, or without one the memory
 * available without swapping; infinite where the system does not report it. */
double availableMemory();

/** Throws Error, which begins with `subject`, when that much memory [bytes] is not available. */
void requireMemory(const std::string& subject, double bytes);

/** Scope in which the process gets at most `bytes` more memory, std::bad_alloc beyond: for work of
 * unpredictable needs, such as calls of other libraries. Scopes may be nested. */
class MemoryCap {
 public:
  explicit MemoryCap(double bytes);
  ~MemoryCap();
  MemoryCap(const MemoryCap&) = delete;
  MemoryCap& operator=(const MemoryCap&) = delete;
  /** Raises the cap [bytes]. */
  void raise(double bytes);

 private:
  void apply() const;

  double limit;             ///< of the data of the process [bytes]
  unsigned long long outer; ///< limit before this scope [bytes]
};

} // namespace recurse
