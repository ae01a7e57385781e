/** @file
 * Reader of zip archives (the .pk3 files of games), by libzip.
 */
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace recurse {

class ZipArchive {
 public:
  /** Opens an archive. Throws Error naming the file and the reason. */
  explicit ZipArchive(const std::string& path);
  ~ZipArchive();
  ZipArchive(const ZipArchive&) = delete;
  ZipArchive& operator=(const ZipArchive&) = delete;

  /** Names of all files in the archive, in its order. */
  const std::vector<std::string>& names() const { return entries; }
  /** Key of a name: lower case, with '/'. Names with the same key refer to the same file. */
  static std::string normalised(const std::string& name);
  /** Content of a file by its name in names(), not by its key. Throws Error where it is missing, damaged,
   * over 1 GiB or not of the stated size. */
  std::string read(const std::string& name) const;

 private:
  struct Handle;
  std::string path;
  std::unique_ptr<Handle> handle;
  std::vector<std::string> entries;
};

} // namespace recurse
