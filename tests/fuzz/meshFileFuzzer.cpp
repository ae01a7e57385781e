/** @file
 * libFuzzer target: any bytes at all as a model that Assimp reads; the first byte chooses the kind. Nothing
 * of the importer around it may crash, hang, or throw anything but SceneError, and what it writes must be a
 * scene.
 */
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <unistd.h>

#include "recurse/model/plugIns.h"
#include "recurse/scene/loader.h"

namespace recurse {

void registerMeshFile(PlugIns& plugIns);

/** Of this program alone: the importer. */
const PlugIns& plugIns() {
  static const PlugIns ALL = [] {
    PlugIns p;
    registerMeshFile(p);
    return p;
  }();
  return ALL;
}

} // namespace recurse

namespace {

using namespace recurse;

constexpr const char* KINDS[] = {".obj", ".gltf", ".glb", ".stl", ".ply", ".dae", ".3ds", ".off"};
constexpr size_t KIND_COUNT = sizeof KINDS / sizeof *KINDS;

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  static const std::string FOLDER = std::filesystem::temp_directory_path().string() + "/";
  const std::string name =
      FOLDER + "recurse-fuzz-" + std::to_string(::getpid()) + KINDS[data[0] % KIND_COUNT];
  std::ofstream(name, std::ios::binary)
      .write(reinterpret_cast<const char*>(data + 1), static_cast<std::streamsize>(size - 1));
  ParsedDirective shape = parseParameterText("mesh", "\"string filename\" \"" + name + "\"");
  Diagnostics diagnostics;
  const auto import = plugIns().imports.make(shape, {"import1:", "import1/"}, diagnostics);
  std::filesystem::remove(name);
  if (!import) {
    if (!diagnostics.hasErrors()) std::abort(); // why not is to be said
    return 0;
  }
  Diagnostics told;
  parseScene("WorldBegin\n" + import->text, "imported", "", told);
  if (told.hasErrors()) {
    std::fputs(told.format().c_str(), stderr);
    std::abort();
  }
  return 0;
}
