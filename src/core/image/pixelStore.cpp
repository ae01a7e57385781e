/** @file
 * Pixels in memory and in nameless files.
 */
#include "core/image/pixelStore.h"

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <string>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace recurse::detail {

namespace {

std::atomic<double> limit{INFINITY};
std::atomic<size_t> inMemory{0}, inFiles{0};

/** Descriptor of an unlinked temporary file, which exists until it is closed; negative on failure. Not in
 * /tmp, which may be memory. */
int namelessFile() {
  const char* chosen = std::getenv("TMPDIR");
  std::string name = std::string(chosen && *chosen ? chosen : "/var/tmp") + "/recurse-XXXXXX";
  const int file = ::mkostemp(name.data(), O_CLOEXEC);
  if (file >= 0) ::unlink(name.c_str());
  return file;
}

/** Writes the bytes to a nameless file and maps it; null on failure. */
void* mapInFile(const std::vector<std::byte>& bytes) {
  const int file = namelessFile();
  if (file < 0) return nullptr;
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t written = ::write(file, bytes.data() + done, bytes.size() - done);
    if (written <= 0) break;
    done += size_t(written);
  }
  void* mapped =
      done == bytes.size() ? ::mmap(nullptr, bytes.size(), PROT_READ, MAP_SHARED, file, 0) : MAP_FAILED;
  ::close(file);
  return mapped == MAP_FAILED ? nullptr : mapped;
}

} // namespace

PixelStore::PixelStore(std::vector<std::byte> bytes) {
  if (!bytes.empty() && double(inMemory) + double(bytes.size()) > limit) mapped = mapInFile(bytes);
  if (mapped) {
    mappedSize = bytes.size();
    inFiles += mappedSize;
    return;
  }
  own = std::move(bytes);
  inMemory += own.size();
}

PixelStore::~PixelStore() {
  inMemory -= own.size();
  if (!mapped) return;
  inFiles -= mappedSize;
  ::munmap(mapped, mappedSize);
}

void PixelStore::rest() const {
  if (mapped) ::madvise(mapped, mappedSize, MADV_DONTNEED);
}

std::pair<size_t, size_t> PixelStore::totals() { return {inMemory, inFiles}; }

void PixelStore::setLimit(double bytes) { limit = bytes; }

} // namespace recurse::detail
