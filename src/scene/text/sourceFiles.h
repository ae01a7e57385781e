/** @file
 * Files of a scene: finding them, and reading each one once, plain or compressed.
 */
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scene/text/lexer.h"

namespace recurse::sceneFile {

/** Path of `name` relative to `directory`, unless `name` is absolute. */
std::string joinPath(const std::string& directory, const std::string& name);
/** Directory part of a path; empty where there is none. */
std::string directoryOf(const std::string& path);
/** True for an existing file that is neither a directory nor a device. */
bool isRegularFile(const std::string& path);
/**
 * Path of the file `name`: relative to `directory`, else to `topDirectory`. Empty where neither exists;
 * `tried` then lists both paths.
 */
std::string findFile(const std::string& name, const std::string& directory, const std::string& topDirectory,
                     std::string& tried);

/**
 * Text of a file, decompressed if it is gzip. Throws Error with the reason; refuses files that are not
 * regular, because a device or pipe may never end.
 */
std::string readTextFile(const std::string& path);

/** Reads each file once, and keeps the texts alive for the tokens and locations that refer to them. */
class SourceFiles {
 public:
  /** Source of the file at `path`. Throws Error. */
  const Source& open(const std::string& path);
  const Source& addText(std::string text, const std::string& name, const std::string& directory);

  /** Texts of all files read, by their paths. */
  std::vector<std::shared_ptr<const SourceText>> all() const;

  /** Stores a string for the lifetime of this object. */
  const std::string& keep(std::string text) { return *kept.insert(std::move(text)).first; }

  std::string topDirectory;
  /** Files by the directory of the including file and the name given there. */
  std::map<std::pair<std::string, std::string>, const Source*> included;
  /** Values of the track `$name`, and their text. */
  struct TrackText {
    const Source* source = nullptr;
    std::vector<double> values;
    size_t uses = 0;
  };
  std::map<std::string, TrackText, std::less<>> tracks;

 private:
  std::map<std::string, std::unique_ptr<Source>> files;
  std::vector<std::unique_ptr<Source>> texts;
  std::set<std::string> kept;
};

} // namespace recurse::sceneFile
