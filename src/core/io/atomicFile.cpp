/** @file
 * Temporary file, rename, and a table of names that a signal handler can read.
 */
#include "recurse/core/io/atomicFile.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <set>
#include <string_view>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "recurse/core/io/error.h"
#include "recurse/core/io/files.h"

namespace recurse {

namespace fs = std::filesystem;

namespace {

/** Entry of a table in fixed memory, with flags: a signal handler must neither lock nor allocate. */
struct Slot {
  std::atomic<bool> taken{false}, filled{false};
  char name[PATH_MAX];
};
std::array<Slot, 64> slots;

int remember(const std::string& name) {
  if (name.size() >= PATH_MAX) return -1;
  for (size_t i = 0; i < slots.size(); ++i) {
    if (slots[i].taken.exchange(true)) continue;
    std::memcpy(slots[i].name, name.c_str(), name.size() + 1);
    slots[i].filled.store(true);
    return static_cast<int>(i);
  }
  return -1; // beyond 64 open files, the last ones are not removed by a hard interrupt
}

void forget(int slot) {
  if (slot < 0) return;
  slots[static_cast<size_t>(slot)].filled.store(false);
  slots[static_cast<size_t>(slot)].taken.store(false);
}

[[noreturn]] void failFor(const std::string& name, int reason) {
  throw Error(name + ": cannot be written: " + std::strerror(reason));
}

fs::path folderOf(const std::string& target) {
  const fs::path folder = fs::path(target).parent_path();
  return folder.empty() ? fs::path(".") : folder;
}

/** Target of the name once links are followed, so that a rename does not replace the link. */
std::string resolved(const std::string& name) {
  std::error_code error;
  const fs::path real = fs::canonical(name, error);
  return error ? name : real.string();
}

bool isSpecialFile(const std::string& target, struct stat& status) {
  return ::stat(target.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

/** Name of a temporary file: PREFIX, process, '-', number, SUFFIX. */
constexpr std::string_view PREFIX = ".recurse-", SUFFIX = ".tmp";

/** Process in the name of a temporary file; 0: the name is another. */
pid_t writerOf(const std::string& name) {
  if (!name.starts_with(PREFIX)) return 0;
  const char* const end = name.data() + name.size();
  pid_t process = 0;
  const auto first = std::from_chars(name.data() + PREFIX.size(), end, process);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != '-') return 0;
  unsigned number = 0;
  const auto second = std::from_chars(first.ptr + 1, end, number);
  if (second.ec != std::errc() || std::string_view(second.ptr, end) != SUFFIX) return 0;
  return std::max(process, 0);
}

/** Removes temporary files of killed runs from a folder that this process has not visited before. A writer on
 * another host or in another container cannot be seen, but changes its file within a day. */
void removeOrphans(const fs::path& folder) {
  static std::mutex mutex;
  static std::set<std::string> visited;
  {
    const std::lock_guard<std::mutex> guard(mutex);
    if (!visited.insert(resolved(folder.string())).second) return;
  }
  constexpr std::chrono::hours LONGEST_WRITE(24);
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const pid_t writer = writerOf(at->path().filename().string());
    if (writer == 0) continue;
    std::error_code unknown;
    if (at->symlink_status(unknown).type() != fs::file_type::regular) continue;
    const fs::file_time_type changed = fs::last_write_time(at->path(), unknown);
    const bool isAlive = ::kill(writer, 0) == 0 || errno != ESRCH;
    if (!unknown && !isAlive && fs::file_time_type::clock::now() - changed > LONGEST_WRITE)
      ::unlink(at->path().c_str());
  }
}

} // namespace

AtomicFile::AtomicFile(const std::string& name) : givenName(name), target(resolved(name)) {
  checkFileWritable(name);
  struct stat status {};
  if (isSpecialFile(target, status)) {
    descriptor = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor < 0) fail(errno);
    return;
  }
  removeOrphans(folderOf(target));
  static std::atomic<unsigned> counter{0};
  // A file of this name can belong to a process with the same id in another container or on another host, or
  // to one that was killed.
  constexpr int MAX_TRIES = 100'000;
  int tries = 0;
  do {
    temporary = (folderOf(target) / (std::string(PREFIX) + std::to_string(::getpid()) + "-" +
                                     std::to_string(counter.fetch_add(1)) + std::string(SUFFIX)))
                    .string();
    descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (descriptor < 0 && errno == EEXIST && ++tries < MAX_TRIES);
  if (descriptor < 0) {
    temporary.clear();
    fail(errno);
  }
  slot = remember(temporary);
  // An existing file keeps its permissions; where that is not possible it still is written.
  if (::stat(target.c_str(), &status) == 0 && ::fchmod(descriptor, status.st_mode & 07777) != 0) errno = 0;
}

AtomicFile::~AtomicFile() {
  if (descriptor >= 0) ::close(descriptor);
  if (!temporary.empty()) ::unlink(temporary.c_str());
  forget(slot);
}

void AtomicFile::write(const void* data, size_t size) {
  const char* from = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = ::write(descriptor, from, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(errno);
    from += written;
    size -= static_cast<size_t>(written);
  }
}

void AtomicFile::commit() {
  const int closing = descriptor;
  descriptor = -1;
  if (::close(closing) != 0) fail(errno); // network file systems report a full disk only here
  if (temporary.empty()) return;
  if (::rename(temporary.c_str(), target.c_str()) != 0) fail(errno);
  temporary.clear();
  forget(slot);
  slot = -1;
}

void AtomicFile::fail(int reason) const { failFor(givenName, reason); }

void checkFileWritable(const std::string& fileName) {
  if (fileName.empty()) throw Error("the name of the output file is empty");
  const std::string target = resolved(fileName);
  struct stat status {};
  if (::stat(target.c_str(), &status) == 0) {
    if (S_ISDIR(status.st_mode)) failFor(fileName, EISDIR);
    // A rename could replace a write-protected file, against the intention of its owner.
    if (::access(target.c_str(), W_OK) != 0) failFor(fileName, errno);
    // Writing to special files other than character devices and open streams may wait for a reader for ever.
    if (!S_ISREG(status.st_mode) && !S_ISCHR(status.st_mode) && !isOpenStream(target))
      throw Error(fileName + ": cannot be written: it is " + specialKind(target) + ", not a file");
    if (!S_ISREG(status.st_mode)) return;
  } else if (errno != ENOENT) {
    failFor(fileName, errno);
  }
  const std::string folder = folderOf(target).string();
  if (::stat(folder.c_str(), &status) != 0)
    throw Error(fileName + ": cannot be written: no such folder: " + folder);
  if (!S_ISDIR(status.st_mode)) failFor(fileName, ENOTDIR);
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    throw Error(fileName + ": cannot be written: the folder " + folder + ": " + std::strerror(errno));
  if (fs::path(target).filename().string().size() > NAME_MAX) failFor(fileName, ENAMETOOLONG);
}

void removeTemporaryFiles() noexcept {
  for (Slot& slot : slots)
    if (slot.filled.load()) ::unlink(slot.name);
}

} // namespace recurse
