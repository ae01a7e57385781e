/** @file
 * Files of a game: layered archives, and loose maps beside them.
 */
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "recurse/core/io/zipArchive.h"

namespace recurse {

/** Files by their names inside the game, such as maps/one.bsp; case and the kind of slashes are ignored. */
class GameFiles {
 public:
  /** Archives (.pk3), of which later ones win, and maps (.bsp). A map in a folder "maps" adds the files in
   * the sibling folders. Throws Error. */
  explicit GameFiles(const std::vector<std::string>& paths);
  GameFiles(const GameFiles&) = delete;
  GameFiles& operator=(const GameFiles&) = delete;

  bool has(const std::string& name) const { return entries.contains(ZipArchive::normalised(name)); }
  std::string read(const std::string& name) const;
  /** Archive and name inside it, or path of a file, for messages. */
  std::string where(const std::string& name) const;
  /** Normalised names with this beginning and end; names from later archives come first. */
  std::vector<std::string> list(const std::string& begin, const std::string& end) const;
  /** Index of the archive or map that contains a file. */
  size_t sourceOf(const std::string& name) const { return entries.at(ZipArchive::normalised(name)).source; }
  /** Paths as given to the constructor. */
  const std::vector<std::string>& paths() const { return given; }

 private:
  struct Entry {
    size_t source = 0;
    std::string name; ///< name in the archive, or path of a file
  };
  void addArchive(const std::string& path);
  void addMap(const std::string& path);

  std::vector<std::string> given;
  std::vector<std::unique_ptr<ZipArchive>> archives; ///< null for a map
  std::map<std::string, Entry> entries;              ///< files by normalised names
};

} // namespace recurse
