/** @file
 * Scene made of a model alone, with a camera that sees it, and light.
 */
#pragma once

#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "recurse/model/scene/sceneImport.h"

namespace recurse::apps {

/** True for model files, which an importer reads, judging by their name. */
bool isModelFile(const std::string& fileName);
/** True if the name ends in an extension of scene files in the format of pbrt. */
bool isSceneFile(const std::string& fileName);

/** Choice of a map of a model, and of a camera of a model or scene file. */
struct ModelChoice {
  std::string map; ///< name of a map, if there are several; empty: the only one
  /** Name in the file; of a model also with ':' for ' '. Empty: the first of a scene file, of a model a
   * camera that sees it. */
  std::string camera;

  void addTo(CLI::App& command);
  /** Command-line options of this choice. */
  std::string text() const;
};

struct ModelScene {
  std::string text; ///< content of a scene file
  std::shared_ptr<const MemoryFiles> files;
  std::vector<std::string> filesRead;
  std::string note; ///< parts imported, and parts left out
};

/** Imports a model, or a map of a game with the archives in its folder. `folder`: prefix of file names in the
 * scene. `outside`: rule for files outside of the model's folder. Null after an error, which the diagnostics
 * have. Throws Error (BAD_USAGE) for a choice that does not exist. */
std::unique_ptr<ModelScene> modelScene(const std::string& fileName, const ModelChoice& choice,
                                       const std::string& folder, const std::string& outside,
                                       Diagnostics& diagnostics);

/** Throws Error (BAD_USAGE) unless the camera of a scene has this name, or the name is empty. */
void requireCamera(const SceneDescription& scene, const std::string& name);

/** Reads a scene file, or a model as a scene. */
SceneDescription loadSceneOrModel(const std::string& fileName, const ModelChoice& choice,
                                  Diagnostics& diagnostics, double frame = 0);

} // namespace recurse::apps
