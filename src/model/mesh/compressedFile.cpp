/** @file
 * Opening of a file, and filling of its buffer.
 */
#include "model/mesh/compressedFile.h"

#include <cerrno>
#include <filesystem>

#include "recurse/core/io/error.h"

namespace recurse {

CompressedFile::CompressedFile(const FileReference& source)
    : path(source.path), content(source.content), buffer(content ? 0 : size_t{1} << 18) {
  if (content) return;
  file = gzopen(path.c_str(), "rb");
  if (!file) throw Error(path + ": cannot be opened: " + std::strerror(errno));
  gzbuffer(file, 1u << 17);
}

uint64_t CompressedFile::storedBytes() const {
  std::error_code error;
  const uint64_t bytes = content ? content->size() : std::filesystem::file_size(path, error);
  return error ? 0 : bytes;
}

bool CompressedFile::fill() {
  if (content) { // content in memory is one buffer
    const bool more = end == 0 && !content->empty();
    end = content->size();
    return more;
  }
  base += end;
  position = end = 0;
  const int got = gzread(file, buffer.data(), static_cast<unsigned>(buffer.size()));
  if (got > 0) {
    end = static_cast<size_t>(got);
    return true;
  }
  int code = 0;
  std::string why = gzerror(file, &code);
  if (why.starts_with(path + ": ")) why.erase(0, path.size() + 2);
  if (code == Z_ERRNO) throw Error(path + ": cannot be read: " + std::strerror(errno));
  if (code != Z_OK && code != Z_STREAM_END)
    throw Error(path + ": at byte " + std::to_string(base) + ": the gzip data is damaged or cut off: " + why);
  return false;
}

} // namespace recurse
