/** @file
 * Identity of files by device and inode, and by canonical paths where no file exists yet.
 */
#include "recurse/core/io/files.h"

#include <algorithm>
#include <filesystem>

#include <sys/stat.h>

#include "recurse/core/io/error.h"

namespace recurse {

namespace fs = std::filesystem;

namespace {

bool sameInode(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

fs::path canonicalPath(const std::string& name) {
  std::error_code error;
  const fs::path absolute = fs::absolute(name, error), real = fs::weakly_canonical(absolute, error);
  return error ? absolute.lexically_normal() : real;
}

} // namespace

bool isSameFile(const std::string& a, const std::string& b) {
  struct stat statusA {
  }, statusB{};
  const bool hasA = ::stat(a.c_str(), &statusA) == 0, hasB = ::stat(b.c_str(), &statusB) == 0;
  if (hasA != hasB) return false;
  if (!hasA) return canonicalPath(a) == canonicalPath(b);
  const auto keepsData = [](const struct stat& s) { return S_ISREG(s.st_mode) || S_ISDIR(s.st_mode); };
  return keepsData(statusA) && sameInode(statusA, statusB);
}

bool isInside(const std::string& name, const std::string& folder) {
  const fs::path file = canonicalPath(name), base = canonicalPath(folder.empty() ? "." : folder) / "";
  const auto [end, inFile] = std::mismatch(base.begin(), std::prev(base.end()), file.begin(), file.end());
  return end == std::prev(base.end()) && inFile != file.end();
}

bool isOpenStream(const std::string& name) {
  struct stat status {
  }, open{};
  if (::stat(name.c_str(), &status) != 0 || S_ISREG(status.st_mode) || S_ISDIR(status.st_mode)) return false;
  std::error_code error;
  for (fs::directory_iterator i("/proc/self/fd", error), end; !error && i != end; i.increment(error))
    if (::stat(i->path().c_str(), &open) == 0 && sameInode(status, open)) return true;
  return false;
}

std::string specialKind(const std::string& name) {
  struct stat status {};
  if (::stat(name.c_str(), &status) != 0 || S_ISREG(status.st_mode)) return {};
  return S_ISDIR(status.st_mode)    ? "a folder"
         : S_ISFIFO(status.st_mode) ? "a named pipe"
         : S_ISSOCK(status.st_mode) ? "a socket"
                                    : "a device";
}

void requireReadable(const std::string& name) {
  const std::string kind = specialKind(name);
  if (!kind.empty() && !isOpenStream(name))
    throw Error(name + ": cannot be read: it is " + kind + ", not a file");
}

} // namespace recurse
