/** @file
 * Files that may be compressed with gzip, read byte by byte.
 */
#pragma once

#include <cstring>
#include <string>
#include <vector>
#include <zlib.h>

#include "recurse/core/io/fileReference.h"

namespace recurse {

/** Bytes of a file, decompressed if it is gzip, with the position in them. */
class CompressedFile {
 public:
  explicit CompressedFile(const FileReference& source);
  ~CompressedFile() {
    if (file) gzclose(file);
  }
  CompressedFile(const CompressedFile&) = delete;
  CompressedFile& operator=(const CompressedFile&) = delete;

  /** Next byte; -1 at the end. */
  int get() {
    if (position == end && !fill()) return -1;
    const auto c = static_cast<unsigned char>(data()[position++]);
    if (c == '\n') ++line;
    return c;
  }
  int peek() {
    if (position == end && !fill()) return -1;
    return static_cast<unsigned char>(data()[position]);
  }
  /** Reads `count` bytes. False when the file ends before. */
  bool read(char* to, size_t count) {
    if (end - position >= count) { // the usual case
      std::memcpy(to, data() + position, count);
      position += count;
      return true;
    }
    for (size_t i = 0; i < count; ++i) {
      if (position == end && !fill()) return false;
      to[i] = data()[position++];
    }
    return true;
  }
  bool skip(uint64_t count) {
    while (count > 0) {
      if (position == end && !fill()) return false;
      const uint64_t step = std::min<uint64_t>(count, end - position);
      position += step;
      count -= step;
    }
    return true;
  }
  uint64_t offset() const { return base + position; }
  uint64_t lineNumber() const { return line; }
  const std::string& name() const { return path; }
  bool compressed() const { return file && !gzdirect(file); }
  /** Size of the file as stored [bytes]; 0 if unknown. */
  uint64_t storedBytes() const;

 private:
  const char* data() const { return content ? content->data() : buffer.data(); }
  bool fill();

  std::string path;
  std::shared_ptr<const std::string> content; ///< null: the bytes come from `file`
  gzFile file = nullptr;
  std::vector<char> buffer;
  size_t position = 0, end = 0;
  uint64_t base = 0; ///< offset of the buffer in the file
  uint64_t line = 1;
};

} // namespace recurse
