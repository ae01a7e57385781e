/** @file
 * The options and the run that every command with a render in it shares.
 */
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/load/loadedScene.h"
#include "apps/options/integratorOptions.h"
#include "apps/run/firstPicture.h"
#include "apps/run/interrupt.h"
#include "apps/run/renderOutput.h"
#include "recurse/core/io/fileLock.h"
#include "recurse/render/checkpoint.h"
#include "recurse/render/render.h"

namespace recurse::apps {

/** The options once they have been understood. */
struct RenderPlan {
  LoadOverrides overrides;
  std::optional<int> samples;
  std::optional<uint64_t> seed;
  double timeLimit = 0, errorTarget = 0;
  std::optional<double> firstSampleTime;  ///< see RenderSettings
  int threads = 0;                        ///< 0: one for each core
  int64_t firstSample = 0, endSample = 0; ///< see RenderSettings
  std::string checkpoint;                 ///< file to keep the render in; empty: none
  double checkpointInterval = 60;         ///< seconds
  bool resume = false;                    ///< from that file, where it exists
  bool adaptive = false;                  ///< see SampleAllocation
  /** Gets the picture as it grows, first a FirstPicture; see RenderSettings::look. Messages go to `say`. */
  using Look = std::function<double(const std::function<Image()>& picture,
                                    const std::function<void(const std::string&)>& say)>;
  Look look;
  /** A FirstPicture takes the place of one whose first sample was not ready within the time limit. */
  bool endsWithFirstPicture = false;
  bool limitsFirstPass = false; ///< see RenderSettings; also where a FirstPicture may take its place

  /** With what the scene says where the options do not. */
  RenderSettings settings(const Scene& scene) const;
};

struct RenderOptions {
  std::string scene;
  ModelChoice model;
  IntegratorOptions integrator;
  std::optional<std::string> samples, timeLimit, errorTarget, threads, seed, resolution, cropWindow,
      textureMemory, memory;
  std::string statistics, progress = "auto", work = "2m";
  bool quiet = false, verbose = false, lenient = false, compact = false, adaptive = false;

  /** The scene file, which is the first positional argument, and what of a model is asked for. */
  void addSceneTo(CLI::App& command);
  /** All others. */
  void addTo(CLI::App& command);
  /** Throws Error (BAD_USAGE). */
  RenderPlan plan() const;
  /** The part of a command line that gives the same picture, whatever the scene file and the defaults
   * become: scene and options, without what the command itself adds. */
  std::string text(const LoadedScene& loaded, const RenderSettings& settings) const;
};

/** What a render leaves. While it lives, Ctrl-C does not end the program and nobody else gets at the
 * checkpoint, so that what was rendered can be written. */
struct RenderResult {
  const LoadedScene& loaded;
  uint64_t seed = 0;
  std::vector<PathClass> classes; ///< the film's layers
  std::string optionsText;        ///< RenderOptions::text
  Film film;                      ///< a FirstPicture where that has taken its place
  RenderStatistics statistics;
  std::string checkpointFailure; ///< why the checkpoint could not be written; empty where it could
  std::unique_ptr<const GracefulStop> graceful;
  std::unique_ptr<const FileLock> checkpointLock;

  bool isInterrupted() const { return statistics.stopReason == StopReason::INTERRUPTED; }
  /** True once the render, or what follows it, is to end. */
  const std::atomic<bool>& stopFlag() const { return graceful->flag(); }
  /** Says why the picture is black where it is, and adds that to the warnings; nothing after an interrupt.
   * Takes some seconds at most. */
  void explainBlackness();
  /** `command` and `rest` are what stands before and after the options of the render. */
  RenderReport report(const std::string& command, const std::string& rest = {}) const;
};

/** May change the progress before it is shown. */
using Retell = std::function<void(RenderProgress&)>;

/** Renders with progress and messages as the options ask for them. Throws Error (INTERRUPTED) when an
 * interrupt came before the first sample, and where the render cannot go on from its checkpoint. */
RenderResult renderLoaded(const LoadedScene& loaded, const PathClasses& classes, const RenderPlan& plan,
                          const RenderOptions& options, const Retell& retell = {});

} // namespace recurse::apps
