/** @file
 * Transfer of a scene's files: for each its path, then its content in pieces and an empty piece; an empty
 * path at the end.
 */
#include "apps/load/sentScene.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "recurse/core/io/error.h"

namespace recurse::apps {

namespace {

namespace fs = std::filesystem;

/** Largest piece [bytes]. */
constexpr size_t PIECE = size_t(16) << 20;

/** Absolute path, not normalised: relative names resolve in the copy in the same way. */
std::string absolutePath(const std::string& path) { return fs::absolute(path).string(); }

} // namespace

void sendScene(const Cluster& cluster, const LoadedScene& loaded) {
  cluster.tellAll(absolutePath(loaded.fileName));
  std::vector<char> piece(PIECE);
  for (const std::string& file : loaded.files) {
    std::ifstream in(file, std::ios::binary);
    if (!in) {
      cluster.tellAll("");
      throw Error("--send-scene: cannot read " + file + ": " + std::strerror(errno));
    }
    cluster.tellAll(absolutePath(file));
    while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())).gcount() > 0)
      cluster.tellAll(std::string(piece.data(), static_cast<size_t>(in.gcount())));
    cluster.tellAll("");
  }
  cluster.tellAll("");
}

void sendNoScene(const Cluster& cluster) { cluster.tellAll(""); }

ReceivedScene::ReceivedScene(const Cluster& cluster) {
  const std::string name = cluster.tellAll("");
  if (name.empty()) throw Error("rank 0 could not load the scene");
  std::string pattern = (fs::temp_directory_path() / "recurse-scene-XXXXXX").string();
  const char* made = ::mkdtemp(pattern.data());
  std::string failure = made ? "" : std::strerror(errno);
  folder = pattern;
  // After a failure the pieces are still received, because the broadcasts involve every process.
  for (std::string file = cluster.tellAll(""); !file.empty(); file = cluster.tellAll("")) {
    const std::string path = folder + file;
    std::error_code ignored;
    if (failure.empty()) fs::create_directories(fs::path(path).parent_path(), ignored);
    std::ofstream out(failure.empty() ? path : "", std::ios::binary);
    for (std::string piece = cluster.tellAll(""); !piece.empty(); piece = cluster.tellAll(""))
      out.write(piece.data(), static_cast<std::streamsize>(piece.size()));
    if (failure.empty() && !out.flush()) failure = std::strerror(errno);
  }
  scene = folder + name;
  if (failure.empty()) return;
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  throw Error("--send-scene: cannot write to " + folder + ": " + failure);
}

ReceivedScene::~ReceivedScene() {
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
}

} // namespace recurse::apps
