/** @file
 * A model alone as a scene: with a camera that sees it, and light.
 */
#pragma once

#include <memory>
#include <string>

#include "recurse/model/sceneImport.h"

namespace recurse::apps {

/** True for a file that is not a scene and that an importer reads, judging by its name. */
bool isModelFile(const std::string& fileName);

struct ModelScene {
  std::string text; ///< of a scene file
  std::shared_ptr<const MemoryFiles> files;
  std::vector<std::string> filesRead;
  std::string note; ///< what was taken and left out
};

/** Imports a model; `folder` is the prefix of the names of files in the scene. Null where it failed, and the
 * diagnostics say why. */
std::unique_ptr<ModelScene> modelScene(const std::string& fileName, const std::string& folder,
                                       Diagnostics& diagnostics);

/** Reads a scene file, or a model as a scene. */
SceneDescription loadSceneOrModel(const std::string& fileName, Diagnostics& diagnostics, double frame = 0);

} // namespace recurse::apps
