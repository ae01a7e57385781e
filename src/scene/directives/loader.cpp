/** @file
 * Entry points of the scene-file reader.
 */
#include "recurse/scene/directives/loader.h"

#include "scene/directives/sceneParser.h"

namespace recurse {

using namespace sceneFile;

namespace {

SceneDescription readScene(SourceFiles& files, const Source& top, Diagnostics& diagnostics,
                           const std::string& camera, double frame = 0) {
  SceneDescription scene;
  scene.frame = frame;
  scene.fileName = top.text->name;
  files.topDirectory = top.directory;
  SceneParser(scene, files, diagnostics, camera).parse(top);
  scene.sources = files.all();
  return scene;
}

} // namespace

SceneDescription loadScene(const std::string& fileName, Diagnostics& diagnostics, double frame,
                           const std::string& camera) {
  SourceFiles files;
  return readScene(files, files.open(fileName), diagnostics, camera, frame);
}

SceneDescription parseScene(const std::string& text, const std::string& name, const std::string& directory,
                            Diagnostics& diagnostics, const std::string& camera) {
  SourceFiles files;
  return readScene(files, files.addText(text, name, directory), diagnostics, camera);
}

} // namespace recurse
