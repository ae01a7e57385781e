/** @file
 * References to files of a scene: on the disk, or in memory, extracted by an importer from a larger file.
 */
#pragma once

#include <map>
#include <memory>
#include <string>

namespace recurse {

struct FileReference {
  std::string path;                           ///< also for messages
  std::shared_ptr<const std::string> content; ///< null: the file is on the disk

  FileReference(std::string path, std::shared_ptr<const std::string> content = nullptr)
      : path(std::move(path)), content(std::move(content)) {}
  FileReference(const char* path) : path(path) {}
};

/** Contents of files in memory, by the names that a scene uses for them. */
using MemoryFiles = std::map<std::string, std::shared_ptr<const std::string>>;

} // namespace recurse
