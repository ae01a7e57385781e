/** @file
 * The files of a game: several archives one over the other, and maps that lie beside them.
 */
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "recurse/core/io/zipArchive.h"

namespace recurse {

/** Names are those inside of the game, such as maps/one.bsp; case and the kind of slashes do not count. */
class GameFiles {
 public:
  /** Archives (.pk3), of which later ones win, and maps (.bsp). A map in a folder "maps" brings the files in
   * the folders beside that one. Throws Error. */
  explicit GameFiles(const std::vector<std::string>& paths);
  GameFiles(const GameFiles&) = delete;
  GameFiles& operator=(const GameFiles&) = delete;

  bool has(const std::string& name) const { return entries.contains(ZipArchive::normalised(name)); }
  std::string read(const std::string& name) const;
  /** Archive and name inside of it, or path, for messages. */
  std::string where(const std::string& name) const;
  /** Normalised names that begin and end so, those of later archives first. */
  std::vector<std::string> list(const std::string& begin, const std::string& end) const;
  /** The archive or map of which a file is. */
  size_t sourceOf(const std::string& name) const { return entries.at(ZipArchive::normalised(name)).source; }
  /** As given. */
  const std::vector<std::string>& paths() const { return given; }

 private:
  struct Entry {
    size_t source = 0;
    std::string name; ///< in its archive, or the path of a file
  };
  void addArchive(const std::string& path);
  void addMap(const std::string& path);

  std::vector<std::string> given;
  std::vector<std::unique_ptr<ZipArchive>> archives; ///< null for a map
  std::map<std::string, Entry> entries;              ///< by normalised names
};

} // namespace recurse
