/** @file
 * Scenes written for other renderers load without an error. They are next to the checkout, or in the folder
 * of the environment variable RECURSE_SHARED; without them the test is empty.
 */
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>

#include "recurse/scene/directives/loader.h"

using namespace recurse;
namespace fs = std::filesystem;

namespace {

/// Files without a world are parts that scenes include.
bool isWholeScene(const fs::path& file) {
  std::ifstream stream(file);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  return text.find("WorldBegin") != std::string::npos;
}

/// Scenes that a renderer accepts. The folder `repro` is excluded: its inputs are deliberately invalid.
std::vector<fs::path> sceneFiles() {
  const char* place = std::getenv("RECURSE_SHARED");
  const fs::path root = place ? fs::path(place) : fs::path(RECURSE_SOURCE_DIR) / ".." / "shared";
  std::vector<fs::path> files;
  for (const fs::path& folder :
       {root / "reference", root / "real", fs::path(RECURSE_SOURCE_DIR) / "scenes"}) {
    std::error_code error;
    if (!fs::is_directory(folder, error)) continue;
    for (auto entry = fs::recursive_directory_iterator(folder); entry != fs::recursive_directory_iterator();
         ++entry) {
      if (entry->path().filename() == "repro") entry.disable_recursion_pending();
      if (entry->path().extension() == ".pbrt" && isWholeScene(entry->path())) files.push_back(entry->path());
    }
  }
  return files;
}

} // namespace

TEST(RealScenes, LoadWithoutErrors) {
  const std::vector<fs::path> files = sceneFiles();
  ASSERT_GE(files.size(), 10u) << "the scenes of the project itself are always there";
  for (const fs::path& file : files) {
    Diagnostics diagnostics;
    const SceneDescription scene = loadScene(file.string(), diagnostics);
    EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.format();
    EXPECT_TRUE(scene.camera.given()) << file;
    EXPECT_TRUE(scene.film.given()) << file;
    EXPECT_FALSE(scene.shapes.empty()) << file;
    EXPECT_FALSE(scene.areaLights.empty() && scene.lights.empty()) << file;
    for (const ShapeDescription& s : scene.shapes)
      for (const ParsedParameter& p : s.shape.parameters) {
        if (p.name == "P") {
          EXPECT_EQ(p.numbers.size() % 3, 0u) << file;
        }
        if (p.name == "filename") {
          EXPECT_TRUE(fs::exists(fs::path(s.shape.directory) / p.strings.at(0))) << file;
        }
      }
  }
}
