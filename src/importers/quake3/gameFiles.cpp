/** @file
 * Finding and reading of a game's files.
 */
#include "importers/quake3/gameFiles.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "recurse/core/io/error.h"

namespace recurse {

namespace fs = std::filesystem;

GameFiles::GameFiles(const std::vector<std::string>& paths) : given(paths) {
  for (const std::string& path : given)
    ZipArchive::normalised(path).ends_with(".bsp") ? addMap(path) : addArchive(path);
}

void GameFiles::addArchive(const std::string& path) {
  const size_t source = archives.size();
  const ZipArchive& archive = *archives.emplace_back(std::make_unique<ZipArchive>(path));
  // The first of several equal normalised names in one archive wins.
  std::map<std::string, Entry> found;
  for (const std::string& name : archive.names())
    found.try_emplace(ZipArchive::normalised(name), Entry{source, name});
  for (auto& [name, entry] : found) entries[name] = std::move(entry);
}

void GameFiles::addMap(const std::string& path) {
  const size_t source = archives.size();
  archives.emplace_back();
  const fs::path folder = fs::absolute(path).parent_path();
  if (ZipArchive::normalised(folder.filename().string()) == "maps") {
    const fs::path game = folder.parent_path();
    std::error_code failure;
    for (const char* part : {"textures", "scripts", "models", "env", "gfx"})
      for (fs::recursive_directory_iterator
               i(game / part, fs::directory_options::skip_permission_denied, failure),
           end;
           !failure && i != end; i.increment(failure))
        if (i->is_regular_file(failure))
          entries[ZipArchive::normalised(fs::relative(i->path(), game).generic_string())] = {
              source, i->path().string()};
  }
  entries[ZipArchive::normalised("maps/" + fs::path(path).filename().string())] = {source, path};
}

std::string GameFiles::read(const std::string& name) const {
  const Entry& entry = entries.at(ZipArchive::normalised(name));
  if (archives[entry.source]) return archives[entry.source]->read(entry.name);
  std::ifstream in(entry.name, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (!in) throw Error(entry.name + ": cannot be read");
  return bytes;
}

std::string GameFiles::where(const std::string& name) const {
  const Entry& entry = entries.at(ZipArchive::normalised(name));
  return archives[entry.source] ? given[entry.source] + ": " + entry.name : entry.name;
}

std::vector<std::string> GameFiles::list(const std::string& begin, const std::string& end) const {
  std::vector<std::string> out;
  for (const auto& [name, entry] : entries)
    if (name.starts_with(begin) && name.ends_with(end)) out.push_back(name);
  std::stable_sort(out.begin(), out.end(),
                   [&](const std::string& a, const std::string& b) { return sourceOf(a) > sourceOf(b); });
  return out;
}

} // namespace recurse
