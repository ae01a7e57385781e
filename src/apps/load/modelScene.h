/** @file
 * A model alone as a scene: with a camera that sees it, and light.
 */
#pragma once

#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "recurse/model/scene/sceneImport.h"

namespace recurse::apps {

/** True for a file that is not a scene and that an importer reads, judging by its name. */
bool isModelFile(const std::string& fileName);

/** What of a model is asked for. */
struct ModelChoice {
  std::string map;    ///< of an archive with several; empty: the only one
  std::string camera; ///< by its name in the file, with ':' for ' ' too; empty: one that sees the model

  bool any() const { return !map.empty() || !camera.empty(); }
  void addTo(CLI::App& command);
  /** Options that choose the same. */
  std::string text() const;
};

struct ModelScene {
  std::string text; ///< of a scene file
  std::shared_ptr<const MemoryFiles> files;
  std::vector<std::string> filesRead;
  std::string note; ///< what was taken and left out
};

/** Imports a model, and a map of a game with the archives beside it; `folder` is the prefix of the names of
 * files in the scene, `outside` the rule for files that are not in the model's own folder. Null where it
 * failed, and the diagnostics say why. Throws Error (BAD_USAGE) for a choice that there is not. */
std::unique_ptr<ModelScene> modelScene(const std::string& fileName, const ModelChoice& choice,
                                       const std::string& folder, const std::string& outside,
                                       Diagnostics& diagnostics);

/** Reads a scene file, or a model as a scene. */
SceneDescription loadSceneOrModel(const std::string& fileName, const ModelChoice& choice,
                                  Diagnostics& diagnostics, double frame = 0);

} // namespace recurse::apps
