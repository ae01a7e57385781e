/** @file
 * A file that one process at a time may work with.
 */
#pragma once

#include <string>

namespace recurse {

/** Keeps other processes from locking the same file, by a file beside it that ends in ".lock" and goes with
 * the lock. A process that is killed leaves no lock behind. */
class FileLock {
 public:
  /** Throws Error where another process has the lock, or none can be had. */
  explicit FileLock(const std::string& fileName);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  std::string lockName;
  int descriptor = -1;
};

} // namespace recurse
