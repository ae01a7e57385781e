/** @file
 * Zip archives by libzip.
 */
#include "recurse/core/io/zipArchive.h"

#include <algorithm>
#include <zip.h>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"

namespace recurse {

struct ZipArchive::Handle {
  zip_t* zip = nullptr;
  ~Handle() {
    if (zip) zip_discard(zip);
  }
};

namespace {

/** Limit of one file, larger than any file of a game: an archive can claim a thousand times its own size. */
constexpr zip_uint64_t MAX_ENTRY_BYTES = zip_uint64_t(1) << 30;

} // namespace

std::string ZipArchive::normalised(const std::string& name) {
  std::string out = lowerCase(name);
  std::replace(out.begin(), out.end(), '\\', '/');
  return out;
}

ZipArchive::ZipArchive(const std::string& path) : path(path), handle(std::make_unique<Handle>()) {
  int code = 0;
  handle->zip = zip_open(path.c_str(), ZIP_RDONLY, &code);
  if (!handle->zip) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string reason = zip_error_strerror(&error);
    zip_error_fini(&error);
    throw Error(path + ": cannot be read as a zip archive: " + reason);
  }
  const zip_int64_t count = zip_get_num_entries(handle->zip, 0);
  for (zip_int64_t i = 0; i < count; ++i)
    if (const char* name = zip_get_name(handle->zip, static_cast<zip_uint64_t>(i), 0))
      if (*name && std::string_view(name).back() != '/') entries.emplace_back(name);
}

ZipArchive::~ZipArchive() = default;

std::string ZipArchive::read(const std::string& name) const {
  const auto fail = [&](const std::string& what) { throw Error(path + ": " + name + ": " + what); };
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_stat(handle->zip, name.c_str(), 0, &stat) != 0 || !(stat.valid & ZIP_STAT_SIZE))
    fail("is not in the archive");
  if (stat.size > MAX_ENTRY_BYTES) fail("is larger than 1 GiB");
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(zip_fopen(handle->zip, name.c_str(), 0),
                                                               zip_fclose);
  if (!file) fail(std::string("cannot be read: ") + zip_strerror(handle->zip));
  std::string bytes; // grows with the data present, not with the size claimed
  char chunk[1 << 16];
  for (;;) {
    const zip_int64_t got = zip_fread(file.get(), chunk, sizeof chunk);
    if (got < 0) fail(std::string("cannot be read: ") + zip_file_strerror(file.get()));
    if (got == 0) break;
    if (bytes.size() + static_cast<size_t>(got) > stat.size) fail("is longer than the archive says");
    bytes.append(chunk, static_cast<size_t>(got));
  }
  if (bytes.size() != stat.size) fail("is shorter than the archive says");
  return bytes;
}

} // namespace recurse
