/** @file
 * The options and the run that every command with a render in it shares.
 */
#pragma once

#include <optional>
#include <string>

#include "apps/integratorOptions.h"
#include "apps/loadedScene.h"
#include "recurse/model/film.h"
#include "recurse/transport/render.h"

namespace recurse::apps {

/** The options once they have been understood. */
struct RenderPlan {
  SceneOverrides overrides;
  std::optional<int> samples;
  std::optional<uint64_t> seed;
  double timeLimit = 0;
  int threads = 0; ///< 0: one for each core

  /** With what the scene says where the options do not. */
  RenderSettings settings(const Scene& scene) const;
};

struct RenderOptions {
  std::string scene;
  IntegratorOptions integrator;
  std::optional<std::string> samples, timeLimit, threads, seed, resolution, cropWindow;
  std::string statistics, progress = "auto";
  bool quiet = false, verbose = false, lenient = false;

  /** The scene file, which is the first positional argument. */
  void addSceneTo(CLI::App& command);
  /** All others. */
  void addTo(CLI::App& command);
  /** Throws Error (BAD_USAGE). */
  RenderPlan plan() const;
  /** The part of a command line that gives the same picture, whatever the scene file and the defaults
   * become: scene and options, without what the command itself adds. */
  std::string text(const LoadedScene& loaded, const RenderSettings& settings) const;
};

/** Renders with progress and messages as the options ask for them. */
RenderStatistics renderShown(const LoadedScene& loaded, const PathClasses& classes,
                             const RenderSettings& settings, const RenderOptions& options, Film& film,
                             const std::atomic<bool>& stop);

} // namespace recurse::apps
