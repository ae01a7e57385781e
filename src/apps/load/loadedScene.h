/** @file
 * Scene and integrator made from a scene file, and the report on them.
 */
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "apps/load/modelScene.h"
#include "apps/options/integratorOptions.h"
#include "recurse/model/scene/keptParts.h"
#include "recurse/model/scene/scene.h"
#include "recurse/scene/directives/sceneDescription.h"

namespace recurse::apps {

struct LoadedScene {
  std::shared_ptr<const void> place; ///< owner of temporary files; null: the files are permanent
  std::string fileName;
  SceneDescription description;
  std::unique_ptr<Scene> scene;
  ParsedDirective integratorDirective;
  std::unique_ptr<Integrator> integrator;
  std::vector<std::string> files; ///< paths of the files that were read
  double loadSeconds = 0, buildSeconds = 0;
  size_t warnings = 0; ///< number of warnings, already printed
};

/** Frame of an animation, with the parts kept from the previous frame. */
struct AnimationFrame {
  int number = 0;
  KeptParts kept;
  std::shared_ptr<const LoadedScene> before; ///< previous frame, which keeps images of textures in memory
  bool isFirst = true;
  /** Exposure of the pictures for a display, from the first frame that is not black [stops]; a separate
   * exposure of each frame would flicker. */
  std::optional<double> stops;
  std::string warnings; ///< of the previous frame, which are not repeated
};

/** Overrides of the scene file by the command line. */
struct LoadOverrides : SceneOverrides {
  ModelChoice model;
};

/** Loads a scene file and builds its scene and integrator. Throws Error (BAD_SCENE) for an unreadable file,
 * SceneError with all errors in it, and Error (BAD_USAGE) for unsuitable options. Prints warnings on standard
 * error. Width and height are divided by `reduction`. Without `frame` it is frame 0. */
LoadedScene loadAndBuild(const std::string& fileName, const LoadOverrides& overrides,
                         const IntegratorOptions& options, int reduction = 1,
                         AnimationFrame* frame = nullptr);

/** Builds the description that `read` makes, with its diagnostics among all others; `name` is used as the
 * name of the file. Throws like the function above. */
LoadedScene loadAndBuild(const std::string& name, const std::function<SceneDescription(Diagnostics&)>& read,
                         const LoadOverrides& overrides, const IntegratorOptions& options, int reduction = 1,
                         AnimationFrame* frame = nullptr);

/** Replaces the integrator of a loaded scene by the one of the options, new and unprepared. Throws like
 * loadAndBuild(). `warns`: warnings are printed; false for options with which the scene was loaded. */
void replaceIntegrator(LoadedScene& loaded, const IntegratorOptions& options, bool lenient,
                       bool warns = true);

/** Replaces an integrator that does not render all of the scene by path, with a warning. */
void renderByPathIfNeeded(LoadedScene& loaded, Diagnostics& diagnostics);

/** Existing files that a description without imports names, and files that its imports have read, each once,
 * sorted by path. */
std::vector<std::string> filesOf(const SceneDescription& description);

/** Hash of the contents of all files of the scene, and of nothing else. */
std::string contentHash(const SceneDescription& description);

/** Report on the contents and the memory of the scene, and on the settings of its render. */
std::string sceneReport(const LoadedScene& loaded, size_t layers = 1);

} // namespace recurse::apps
