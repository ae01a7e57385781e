/** @file
 * Lock by which only one process at a time works with a file.
 */
#pragma once

#include <string>

namespace recurse {

/** Lock of a file against other FileLocks, of any process: a file beside it whose name ends in ".lock", which
 * is removed with the lock. A process that is killed leaves that file, but no lock. */
class FileLock {
 public:
  /** Throws Error where another FileLock has the lock, or no lock can be had. */
  explicit FileLock(const std::string& fileName);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  std::string lockName;
  int descriptor = -1;
};

} // namespace recurse
