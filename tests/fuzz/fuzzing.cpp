/** @file
 * Imports by the fuzzers, and the plug-ins by which they read files.
 */
#include "fuzz/fuzzing.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "recurse/model/scene/plugIns.h"
#include "recurse/scene/directives/loader.h"

namespace recurse {

void registerMd2(PlugIns& plugIns);
void registerMeshFile(PlugIns& plugIns);
void registerNanoVdb(PlugIns& plugIns);
void registerPlyMesh(PlugIns& plugIns);
void registerQuake3Map(PlugIns& plugIns);
void registerRgbGrid(PlugIns& plugIns);
void registerUniformGrid(PlugIns& plugIns);

const PlugIns& plugIns() {
  static const PlugIns ALL = [] {
    PlugIns p;
    for (const auto add : {registerMd2, registerMeshFile, registerNanoVdb, registerPlyMesh, registerQuake3Map,
                           registerRgbGrid, registerUniformGrid})
      add(p);
    return p;
  }();
  return ALL;
}

void checkImport(const SceneImport& import) {
  Diagnostics told;
  std::string views;
  for (const ImportedCamera& c : import.cameras)
    views += "Camera \"perspective\" \"float fov\" " + sceneText(c.fov) + "\n";
  parseScene(views + "WorldBegin\n" + import.text, "imported", "", told);
  if (!told.hasErrors()) return;
  std::fputs(told.format().c_str(), stderr);
  std::abort();
}

void importAnything(const char* importer, const char* parameter, const std::string& extension,
                    const std::string& bytes, const std::string& more) {
  const std::string name = scratchFile(extension);
  std::ofstream(name, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  Diagnostics diagnostics;
  const auto import = plugIns().imports.make(
      parseParameterText(importer, "\"string " + std::string(parameter) + "\" \"" + name + "\" " + more),
      {"import1:", "import1/"}, diagnostics);
  std::filesystem::remove(name);
  if (!import) {
    if (!diagnostics.hasErrors()) std::abort(); // a failure must have an error message
    return;
  }
  checkImport(*import);
}

} // namespace recurse
