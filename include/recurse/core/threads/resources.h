/** @file
 * Memory and work, asked for before they are taken: a process that takes too much memory is killed without a
 * word, and one that works for hours on what a line of a scene file asks for looks as if it hung.
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

/** Work that is foretold to take longer on one core is refused [s]; without a limit all is allowed. */
void setWorkLimit(double seconds);

/** Throws Error, which begins with `subject`, when work that is foretold to take that long on one core, with
 * what the WorkSum of this thread has, comes to more than the limit. */
void requireWork(const std::string& subject, double seconds);

/** While one lives, requireWork() of this thread adds up: many parts of a scene together have one limit. */
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
