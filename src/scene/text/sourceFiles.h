/** @file
 * Files that a scene consists of: finding them, reading them once, plain or compressed.
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

/** `name` beside `directory`, unless it is absolute. */
std::string joinPath(const std::string& directory, const std::string& name);
/** The directory part of a path; empty where it has none. */
std::string directoryOf(const std::string& path);
/** True for an existing file that is neither a directory nor a device. */
bool isRegularFile(const std::string& path);
/**
 * The file that `name` stands for: beside `directory`, else beside `topDirectory`. Empty where there is none;
 * `tried` then lists the paths looked at.
 */
std::string findFile(const std::string& name, const std::string& directory, const std::string& topDirectory,
                     std::string& tried);

/**
 * The text of a file, decompressed where it is gzip. Throws Error with the reason; refuses what is not a
 * regular file, because a device or pipe may never end.
 */
std::string readTextFile(const std::string& path);

/** Reads each file once, and keeps the texts alive while tokens and places point at them. */
class SourceFiles {
 public:
  /** The file at `path`. Throws Error. */
  const Source& open(const std::string& path);
  const Source& addText(std::string text, const std::string& name, const std::string& directory);

  /** The texts of all files read, by their paths. */
  std::vector<std::shared_ptr<const SourceText>> all() const;

  /** A string that lives as long as this. */
  const std::string& keep(std::string text) { return *kept.insert(std::move(text)).first; }

  std::string topDirectory;
  /** Files by the directory of the one that includes them and the name that it gives. */
  std::map<std::pair<std::string, std::string>, const Source*> included;
  /** The numbers that `$name` stands for, and their text. */
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
