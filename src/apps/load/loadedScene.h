/** @file
 * A scene file taken all the way to a scene and its integrator, and what a person wants to know of them.
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
  std::shared_ptr<const void> place; ///< of files that go when it does; null: they stay
  std::string fileName;
  SceneDescription description;
  std::unique_ptr<Scene> scene;
  ParsedDirective integratorDirective;
  std::unique_ptr<Integrator> integrator;
  std::vector<std::string> files; ///< that it was read from, by their paths
  double loadSeconds = 0, buildSeconds = 0;
  size_t warnings = 0; ///< already printed
};

/** A frame of an animation, and what it takes from the one before. */
struct AnimationFrame {
  int number = 0;
  KeptParts kept;
  std::shared_ptr<const LoadedScene> before; ///< whose textures' pictures are still in memory
  bool isFirst = true;
  /** Exposure of the pictures for a display, by the first frame that is not black; a film that exposed each
   * by itself would flicker. */
  std::optional<double> stops;
  std::string warnings; ///< of the frame before, which are not told again
};

/** What the command line says in the place of the file. */
struct LoadOverrides : SceneOverrides {
  ModelChoice model;
};

/** Throws Error (BAD_SCENE) when the file cannot be read, SceneError with everything that is wrong with it,
 * and Error (BAD_USAGE) for options that do not fit. Prints warnings on standard error. Width and height of
 * the picture are divided by `reduction`. Without `frame` it is that of number 0. */
LoadedScene loadAndBuild(const std::string& fileName, const LoadOverrides& overrides,
                         const IntegratorOptions& options, int reduction = 1,
                         AnimationFrame* frame = nullptr);

/** The same of a description that `read` makes, whose diagnostics are those of the rest; `name` stands for
 * the file's. */
LoadedScene loadAndBuild(const std::string& name, const std::function<SceneDescription(Diagnostics&)>& read,
                         const LoadOverrides& overrides, const IntegratorOptions& options, int reduction = 1,
                         AnimationFrame* frame = nullptr);

/** Gives a scene that is built the integrator of the options, new and unprepared. Throws as loadAndBuild().
 */
void replaceIntegrator(LoadedScene& loaded, const IntegratorOptions& options, bool lenient);

/** Puts path in the place of an integrator that does not render all of the scene, with a warning. */
void renderByPathIfNeeded(LoadedScene& loaded, Diagnostics& diagnostics);

/** The files that a description without imports names and that there are, and those that its imports read,
 * each once. */
std::vector<std::string> filesOf(const SceneDescription& description);

/** A hash of all files that the scene was read from, and of nothing else. */
std::string contentHash(const SceneDescription& description);

/** What the scene contains and needs, and the settings that it would be rendered with. */
std::string sceneReport(const LoadedScene& loaded, size_t layers = 1);

} // namespace recurse::apps
