/** @file
 * The options and the run that every command with a render in it shares.
 */
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "apps/integratorOptions.h"
#include "apps/interrupt.h"
#include "apps/loadedScene.h"
#include "apps/renderOutput.h"
#include "recurse/core/fileLock.h"
#include "recurse/report/checkpoint.h"
#include "recurse/transport/render.h"

namespace recurse::apps {

/** The options once they have been understood. */
struct RenderPlan {
  SceneOverrides overrides;
  std::optional<int> samples;
  std::optional<uint64_t> seed;
  double timeLimit = 0, errorTarget = 0;
  int threads = 0;                        ///< 0: one for each core
  int64_t firstSample = 0, endSample = 0; ///< see RenderSettings
  std::string checkpoint;                 ///< file to keep the render in; empty: none
  double checkpointInterval = 60;         ///< seconds
  bool resume = false;                    ///< from that file, where it exists
  bool adaptive = false;                  ///< see SampleAllocation
  /** Sees the film while it grows; see RenderSettings::look. Messages go to `say`. */
  std::function<double(const Film&, const std::function<void(const std::string&)>& say)> look;
  double lookAfter = 0;

  /** With what the scene says where the options do not. */
  RenderSettings settings(const Scene& scene) const;
};

struct RenderOptions {
  std::string scene;
  IntegratorOptions integrator;
  std::optional<std::string> samples, timeLimit, errorTarget, threads, seed, resolution, cropWindow,
      textureMemory, memory;
  std::string statistics, progress = "auto";
  bool quiet = false, verbose = false, lenient = false, compact = false, adaptive = false;

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

/**
 * A film rendered in the constructor, with progress and messages as the options ask for them. While it lives,
 * Ctrl-C does not end the program, so that what was rendered can be written.
 */
class Rendering {
 public:
  /** May change what is told of the progress before it is shown. */
  using Retell = std::function<void(RenderProgress&)>;

  /** Throws Error (INTERRUPTED) when an interrupt came before the first sample, and where the render cannot
   * go on from its checkpoint. */
  Rendering(const LoadedScene& loaded, const PathClasses& classes, const RenderPlan& plan,
            const RenderOptions& options, const Retell& retell = {});

  const Film& film() const { return kept.film; }
  const RenderStatistics& statistics() const { return figures; }
  /** Why the checkpoint could not be written; empty where it could. */
  const std::string& checkpointFailure() const { return failure; }
  bool interrupted() const { return figures.stopReason == StopReason::INTERRUPTED; }
  /** `command` and `rest` are what stands before and after the options of the render. */
  RenderReport report(const std::string& command, const std::string& rest = {}) const;

 private:
  const LoadedScene& loaded;
  const RenderOptions& options;
  RenderSettings settings;
  const GracefulStop graceful;
  std::optional<FileLock> lock; ///< of the checkpoint, which no other process may replace meanwhile
  Checkpoint kept;
  RenderStatistics figures;
  std::string failure;
};

} // namespace recurse::apps
