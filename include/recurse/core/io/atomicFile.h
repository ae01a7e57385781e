/** @file
 * Files that appear under their name only when they are complete, so that a failed run loses nothing.
 */
#pragma once

#include <cstddef>
#include <string>

namespace recurse {

/**
 * File that is written under a temporary name in the folder of its target and renamed to the target by
 * commit(), after which nothing can be written. Without a commit the temporary file is removed and an
 * existing target stays unchanged. Links to existing files are followed, and an existing target keeps its
 * permissions. A terminal, /dev/null and other character devices, and streams that are open already
 * (/dev/stdout), are written directly; other special files are refused, as by checkFileWritable(). Temporary
 * files that killed processes left in the folder a day ago or earlier are removed.
 * Every function throws Error naming the target and the reason.
 */
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(const void* data, size_t size);
  void commit();

 private:
  [[noreturn]] void fail(int reason) const;

  std::string givenName, target, temporary; ///< temporary: empty when the target is written directly
  int descriptor = -1;
  int slot = -1; ///< index in the table of removeTemporaryFiles(); -1: none
};

/** Throws Error when a file could not be written there: no such folder, no permission, a folder itself, a
 * named pipe. Creates nothing. */
void checkFileWritable(const std::string& fileName);

/** Unlinks the temporary files of up to 64 AtomicFiles that are not committed. Safe in a signal handler that
 * ends the program. */
void removeTemporaryFiles() noexcept;

} // namespace recurse
