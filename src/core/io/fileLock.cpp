/** @file
 * Locks by flock(2), which the system releases when a process ends in any way.
 */
#include "recurse/core/io/fileLock.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "recurse/core/io/error.h"

namespace recurse {

namespace {

/** False when the name refers to a new file by now: the process with the lock has removed its own one. */
bool isStillThere(const std::string& name, int descriptor) {
  struct stat byName {
  }, open{};
  return ::stat(name.c_str(), &byName) == 0 && ::fstat(descriptor, &open) == 0 &&
         byName.st_ino == open.st_ino && byName.st_dev == open.st_dev;
}

} // namespace

FileLock::FileLock(const std::string& fileName) : lockName(fileName + ".lock") {
  for (;;) {
    descriptor = ::open(lockName.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor < 0) throw Error(lockName + ": cannot be written: " + std::strerror(errno));
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
      const int reason = errno;
      ::close(descriptor);
      if (reason == EWOULDBLOCK) throw Error(fileName + ": another process uses it");
      throw Error(lockName + ": cannot be locked: " + std::strerror(reason));
    }
    if (isStillThere(lockName, descriptor)) return;
    ::close(descriptor);
  }
}

FileLock::~FileLock() {
  ::unlink(lockName.c_str());
  ::close(descriptor);
}

} // namespace recurse
