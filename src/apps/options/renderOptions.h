/** @file
 * Options and run of a render, shared by all commands that render.
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

/** Parsed options of a render. */
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
  bool resume = false;                    ///< continue from that file, if it exists
  bool adaptive = false;                  ///< see SampleAllocation
  /** Viewer of the growing picture, first a FirstPicture; see RenderSettings::look. `say`: messages. */
  using Look = std::function<double(const std::function<Image()>& picture,
                                    const std::function<void(const std::string&)>& say)>;
  Look look;
  /** Questions to the running render; see RenderSettings. Both or none are set. */
  std::function<bool()> isAsked;
  std::function<void(const RenderPause&)> answer;
  /** True if a FirstPicture replaces a picture without a sample at the time limit. */
  bool endsWithFirstPicture = false;
  bool limitsFirstPass = false; ///< see RenderSettings; set too if a FirstPicture may replace the picture

  /** Settings of the options; the scene's values are the defaults. */
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

  /** Declares the scene file, which is the first positional argument, and ModelChoice. */
  void addSceneTo(CLI::App& command);
  /** Declares all other options. */
  void addTo(CLI::App& command);
  /** Parses the options. Throws Error (BAD_USAGE). */
  RenderPlan plan() const;
  /** Part of a command line that gives the same picture, even if settings in the scene file or defaults
   * change: scene and options, without the ones that the command itself adds. */
  std::string text(const LoadedScene& loaded, const RenderSettings& settings) const;
};

/** Result of a render. During its lifetime Ctrl-C does not end the program, and the checkpoint stays locked,
 * so that the result can be written. */
struct RenderResult {
  const LoadedScene& loaded;
  uint64_t seed = 0;
  std::vector<PathClass> classes; ///< the film's layers
  TransientFrames frames;         ///< frames of a transient render, the last layers of `classes`
  std::string optionsText;        ///< RenderOptions::text
  Film film;                      ///< of a FirstPicture, if that has replaced the picture
  RenderStatistics statistics;
  std::string checkpointFailure; ///< why the checkpoint could not be written; empty if it could
  std::unique_ptr<const GracefulStop> graceful;
  std::unique_ptr<const FileLock> checkpointLock;

  bool isInterrupted() const { return statistics.stopReason == StopReason::INTERRUPTED; }
  /** True once the render, or the work after it, has to end. */
  const std::atomic<bool>& stopFlag() const { return graceful->flag(); }
  /** Warns with the reason if the picture is black, on standard error and in `statistics`; not after an
   * interrupt. Takes some seconds at most. */
  void explainBlackness();
  /** Report with a command line: `command`, the options of the render, `rest`. */
  RenderReport report(const std::string& command, const std::string& rest = {}) const;
};

/** Callback that may change the progress before it is shown. */
using Retell = std::function<void(RenderProgress&)>;

/** Renders, with progress and messages by the options. Throws Error (INTERRUPTED) after an interrupt before
 * the first sample, and Error if the checkpoint does not fit or no sample is ready in time. */
RenderResult renderLoaded(const LoadedScene& loaded, const PathClasses& classes, const RenderPlan& plan,
                          const RenderOptions& options, const Retell& retell = {});

} // namespace recurse::apps
