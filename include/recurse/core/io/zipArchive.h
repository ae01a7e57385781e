/** @file
 * Files out of a zip archive (the .pk3 files of games), through libzip.
 */
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace recurse {

class ZipArchive {
 public:
  /** Throws Error naming the file and the reason. */
  explicit ZipArchive(const std::string& path);
  ~ZipArchive();
  ZipArchive(const ZipArchive&) = delete;
  ZipArchive& operator=(const ZipArchive&) = delete;

  /** Of all files in it, in the order of the archive. */
  const std::vector<std::string>& names() const { return entries; }
  /** A name in lower case, with '/': names that differ in nothing else stand for the same file. */
  static std::string normalised(const std::string& name);
  /** The name in the archive that looks like `name` where case and the kind of slashes do not count. */
  std::optional<std::string> find(const std::string& name) const;
  /** The content of a file of `names`. Throws Error where it is damaged, or longer than the archive says. */
  std::string read(const std::string& name) const;

 private:
  struct Handle;
  std::string path;
  std::unique_ptr<Handle> handle;
  std::vector<std::string> entries;
};

} // namespace recurse
