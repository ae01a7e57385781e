/** @file
 * Limits of memory and work, checked in advance: the system kills a process that takes too much memory
 * without a message, and a process that works for hours on one line of a scene file seems to hang.
 */
#pragma once

#include <string>

namespace recurse {

/** Sets the total memory of the process [bytes], for availableMemory(); allocations are not limited by it. */
void setMemoryLimit(double bytes);

/** Memory that the process can still take [bytes]: the remainder of setMemoryLimit(), else the memory free
 * without swapping; at most the remainder of the limit of addresses set in the shell, and of the limits of
 * the control groups that the process is in. Infinite where none is known. */
double availableMemory();

/** Throws Error, which begins with `subject`, when that much memory [bytes] is not available. Up to 64 MiB
 * are not checked. */
void requireMemory(const std::string& subject, double bytes);

/** Sets the work that a scene may take, as predicted for one core [s]. Initially unlimited. */
void setWorkLimit(double seconds);

/** Adds the predicted time on one core [s] to the WorkSum of this thread, if any. Throws Error, which begins
 * with `subject`, and adds nothing if the sum, or without a WorkSum this time alone, exceeds the limit. */
void requireWork(const std::string& subject, double seconds);

/** Scope in which the work of requireWork() in this thread adds up, so that all parts of a scene share the
 * limit. A scope within another has a sum of its own, which is not added to the outer one. */
class WorkSum {
 public:
  WorkSum();
  ~WorkSum();
  WorkSum(const WorkSum&) = delete;
  WorkSum& operator=(const WorkSum&) = delete;

 private:
  friend void requireWork(const std::string& subject, double seconds);
  double sum = 0; ///< [s]
  WorkSum* const outer;
};

/** Scope in which the process, with all of its threads, gets at most `bytes` more memory, std::bad_alloc
 * beyond: for work of unpredictable needs, such as calls of other libraries. Scopes may be nested. */
class MemoryCap {
 public:
  explicit MemoryCap(double bytes);
  ~MemoryCap();
  MemoryCap(const MemoryCap&) = delete;
  MemoryCap& operator=(const MemoryCap&) = delete;
  /** Raises the cap by `bytes`. */
  void raise(double bytes);

 private:
  void apply() const;

  double limit;             ///< of the data of the process [bytes]
  unsigned long long outer; ///< limit before this scope [bytes]
};

} // namespace recurse
