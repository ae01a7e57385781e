/** @file
 * Options of a render: declaration, parsing, text; and the run of a render.
 */
#include "apps/options/renderOptions.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <utility>

#include "apps/load/missedLight.h"
#include "apps/options/optionText.h"
#include "apps/run/blackPicture.h"
#include "apps/run/cluster.h"
#include "apps/run/console.h"
#include "apps/view/progressDisplay.h"
#include "recurse/core/image/imageTexture.h"
#include "recurse/core/threads/resources.h"
#include "recurse/transport/integrator/sceneNames.h"

namespace recurse::apps {

RenderSettings RenderPlan::settings(const Scene& scene) const {
  RenderSettings out;
  out.timeLimit = timeLimit;
  out.firstSampleTime = firstSampleTime.value_or(out.firstSampleTime);
  out.seed = seed.value_or(scene.sampler().seed);
  // With a time limit or an error target alone, the number of samples is unlimited.
  out.errorTarget = errorTarget;
  out.firstSample = firstSample;
  out.endSample = endSample;
  out.saveInterval = checkpointInterval;
  out.samplesPerPixel = samples.value_or(timeLimit > 0 || errorTarget > 0 ? 0 : scene.sampler().pixelSamples);
  return out;
}

void RenderOptions::addSceneTo(CLI::App& command) {
  command
      .add_option("scene", scene,
                  "Scene file in the pbrt-v4 text format, also compressed with gzip; or a model")
      ->required()
      ->type_name("SCENE");
  model.addTo(command);
}

void RenderOptions::addTo(CLI::App& command) {
  integrator.addTo(command);
  const auto add = [&](const char* name, auto& target, const char* type, const char* description) {
    return command.add_option(name, target, description)->type_name(type);
  };
  add("--spp", samples, "N",
      "Samples per pixel (default: the scene's; with --time-limit or --error-target: no limit)");
  command.add_flag("--adaptive", adaptive,
                   "Adaptive sampling: pixels get from a quarter of --spp to eight times --spp, by the "
                   "estimated error around them; a crop differs from the same part of the whole picture");
  add("--time-limit", timeLimit, "TIME",
      "Time limit for photons and picture, such as 30s, 2m, 1h30m; the first sample of each pixel may take "
      "1 s more, and pixels without one copy a neighbour. Loading is not included, but has the same limit. "
      "'recurse render' uses plain path tracing if photons are not ready in time");
  add("--error-target", errorTarget, "E",
      "Stop when the relative standard error (95th percentile of pixels) is E, such as 0.05; it does not "
      "include the bias of photon maps");
  add("--nthreads", threads, "N",
      "Number of threads (default: one for each core); the picture does not depend on it");
  add("--seed", seed, "N",
      "Seed of the random numbers; another seed gives an independent picture (default: the scene's)");
  add("--resolution", resolution, "WxH", "Size of the picture in pixels (default: the scene's)");
  add("--cropwindow", cropWindow, "x0,x1,y0,y1", "Render only this part, as fractions of width and height");
  add("--memory", memory, "BYTES",
      "Memory limit of the program, such as 8G; scenes, pictures and photons that need more are errors "
      "(default: the available memory)");
  add("--work", work, "TIME",
      "Limit of the predicted time on one core until a scene's first sample is complete, such as 1h; shapes "
      "that subdivide or overlap beyond it are errors (default: 2m)");
  add("--texture-memory", textureMemory, "BYTES",
      "Memory limit of textures, such as 2G; the rest is kept in a temporary file in TMPDIR or /var/tmp "
      "(default: no limit)");
  command.add_flag("--compact", compact,
                   "Compact acceleration structure: about half of the memory; rays are slower");
  add("--stats", statistics, "FILE", "File for the statistics in JSON");
  add("--progress", progress, "WAY", "Progress on standard error: auto, plain, json or off (default: auto)")
      ->check(CLI::IsMember({"auto", "plain", "json", "off"}))
      ->type_name("WAY");
  CLI::Option* quietFlag = command.add_flag("-q,--quiet", quiet, "Print errors and warnings only");
  command.add_flag("-v,--verbose", verbose, "Print the contents of the scene and the automatic choices")
      ->excludes(quietFlag);
  command.add_flag("--lenient", lenient, "Unknown parameters in the scene are warnings instead of errors");
}

RenderPlan RenderOptions::plan() const {
  RenderPlan plan;
  if (samples) plan.samples = static_cast<int>(parseCount("--spp", *samples, 1, 1 << 30));
  if (timeLimit) plan.timeLimit = parseDuration("--time-limit", *timeLimit);
  if (errorTarget) {
    plan.errorTarget = parseReal("--error-target", *errorTarget);
    if (!(plan.errorTarget > 0)) throw Error("--error-target: must be more than 0", ExitStatus::BAD_USAGE);
  }
  if (memory) setMemoryLimit(double(parseCount("--memory", *memory, 1, int64_t(1) << 50)));
  setWorkLimit(parseDuration("--work", work));
  if (textureMemory)
    setTextureMemory(double(parseCount("--texture-memory", *textureMemory, 1, int64_t(1) << 50)));
  if (threads) plan.threads = static_cast<int>(parseCount("--nthreads", *threads, 1, 4096));
  if (seed) plan.seed = parseSeed("--seed", *seed);
  if (resolution) {
    const std::array<int, 2> size = parseResolution("--resolution", *resolution);
    plan.overrides.width = size[0];
    plan.overrides.height = size[1];
  }
  if (cropWindow) plan.overrides.cropWindow = parseCropWindow("--cropwindow", *cropWindow);
  plan.overrides.lenient = lenient;
  plan.overrides.model = model;
  plan.overrides.compact = compact;
  plan.adaptive = adaptive;
  return plan;
}

std::string RenderOptions::text(const LoadedScene& loaded, const RenderSettings& settings) const {
  std::string out = shellQuoted(scene) + model.text() + " --integrator " +
                    shellQuoted(loaded.integratorDirective.type) + integrator.text();
  if (settings.samplesPerPixel > 0) out += " --spp " + std::to_string(settings.samplesPerPixel);
  if (adaptive) out += " --adaptive";
  if (timeLimit) out += " --time-limit " + shellQuoted(*timeLimit);
  if (errorTarget) out += " --error-target " + shellQuoted(*errorTarget);
  out += " --seed " + std::to_string(settings.seed);
  if (resolution) out += " --resolution " + *resolution;
  if (cropWindow) out += " --cropwindow " + *cropWindow;
  if (lenient) out += " --lenient";
  if (settings.firstSample > 0 || settings.endSample > 0)
    out +=
        " --sample-range " + std::to_string(settings.firstSample) + ":" + std::to_string(settings.endSample);
  return out;
}

namespace {

/** Everything that the samples of a render depend on, except for the seed. */
std::map<std::string, std::string> identityOf(const LoadedScene& loaded, const RenderSettings& settings,
                                              const PathClasses& classes, bool adaptive) {
  const FilmSettings& film = loaded.scene->film();
  const std::string& camera = loaded.description.cameraName;
  std::string integrator = loaded.integratorDirective.type;
  for (const std::string& setting : settingsOf(loaded.integratorDirective)) integrator += ", " + setting;
  std::string crop;
  for (const int x : {film.crop.x0, film.crop.x1, film.crop.y0, film.crop.y1})
    crop += (crop.empty() ? "" : ",") + std::to_string(x);
  std::map<std::string, std::string> out = {
      {"version", VERSION},
      {"scene files (hash)", contentHash(loaded.description)},
      {"camera", camera.empty() ? "without a name" : camera},
      {"integrator", integrator},
      {"resolution", std::to_string(film.width) + "x" + std::to_string(film.height)},
      {"part of the picture in pixels", crop},
      {"path classes", classesText(classes.classes())},
      {"samples per pixel",
       settings.samplesPerPixel > 0 ? std::to_string(settings.samplesPerPixel) : "as many as fit"},
      {"sample distribution", adaptive ? "adaptive" : UNIFORM_SAMPLES}};
  if (classes.isTransient()) out["time of flight"] = classes.frames().text();
  return out;
}

Film emptyFilm(const Scene& scene, const PathClasses& classes) {
  const PixelBounds& crop = scene.film().crop;
  requireMemory("a film of " + std::to_string(crop.width()) + "x" + std::to_string(crop.height()) + " pixels",
                Film::bytes(double(crop.area()), double(classes.layerCount())));
  return {crop, classes.layerCount()};
}

/** Time limit that is over at once; 0 would be none. */
constexpr double NO_TIME_LEFT = std::numeric_limits<double>::min();

/** A render with its messages, its checkpoint and its first picture. */
class RenderRun {
 public:
  RenderRun(const LoadedScene& loaded, const PathClasses& classes, const RenderPlan& plan,
            const RenderOptions& options, const Retell& retell)
      : loaded(loaded), classes(classes), plan(plan), options(options),
        settings(plan.settings(*loaded.scene)),
        display(options.quiet ? ProgressMode::OFF : progressModeOf(options.progress)),
        // Warnings concern the picture, so that they are printed at once and even when quiet.
        log([this](const std::string& text) {
          if (this->options.verbose || text.starts_with("warning")) display.message(text);
        }),
        show([this, &retell](RenderProgress progress) {
          if (retell) retell(progress);
          display.update(progress);
        }),
        optionsText(options.text(loaded, settings)), kept{{},
                                                          {},
                                                          loaded.scene->film().imagingRatio,
                                                          classes.classes(),
                                                          {{settings.seed, settings.firstSample,
                                                            settings.firstSample}},
                                                          {},
                                                          emptyFilm(*loaded.scene, classes),
                                                          {}},
        firstClasses(firstPictureClasses(loaded, classes)) {
    if (plan.adaptive) kept.allocation.emplace(kept.film.bounds(), kept.imagingRatio);
  }

  RenderResult run() {
    if (options.verbose) say(sceneReport(loaded, classes.layerCount()));
    if (!plan.checkpoint.empty() || cluster())
      kept.identity = identityOf(loaded, settings, classes, plan.adaptive);
    if (cluster()) joinCluster();
    if (!plan.checkpoint.empty()) openCheckpoint();
    settings.limitsFirstPass = plan.limitsFirstPass || (plan.endsWithFirstPicture && firstClasses);
    settings.isAsked = plan.isAsked;
    settings.answer = plan.answer;
    if (plan.look) beginLooking();
    const std::string missed = missedText();
    if (!missed.empty()) log("warning: " + missed);
    render();
    if (!cluster() || cluster()->leads()) complete(missed);
    return {loaded,           settings.seed, kept.classes,
            classes.frames(), optionsText,   std::move(isFirst ? first->film : kept.film),
            statistics,       failure,       std::move(graceful),
            std::move(lock)};
  }

 private:
  void joinCluster() const {
    auto identity = kept.identity;
    identity["seed"] = std::to_string(settings.seed);
    cluster()->join(identity);
  }

  void openCheckpoint() {
    lock = std::make_unique<const FileLock>(plan.checkpoint);
    if (plan.resume && std::filesystem::exists(plan.checkpoint)) goOn(Checkpoint::read(plan.checkpoint));
    settings.save = [this](const RenderPosition& position) { save(position); };
  }
  void goOn(Checkpoint before) {
    requireSame(plan.checkpoint, kept.identity, before.identity);
    const Checkpoint::Part &then = before.parts.front(), &now = kept.parts.front();
    if (before.parts.size() > 1)
      throw Error(plan.checkpoint + ": is a sum of several renders and cannot be continued");
    if (then.seed != now.seed || then.first != now.first)
      throw Error(plan.checkpoint + ": has seed " + std::to_string(then.seed) + " and samples from " +
                  std::to_string(then.first) + "; this render has seed " + std::to_string(now.seed) +
                  " and samples from " + std::to_string(now.first));
    settings.from = before.position;
    kept.film = std::move(before.film);
    kept.allocation = std::move(before.allocation);
    log("continuing " + plan.checkpoint);
  }
  void save(const RenderPosition& position) {
    kept.position = position;
    uint64_t most = 0;
    for (size_t i = 0; i < kept.film.bounds().area(); ++i) most = std::max(most, kept.film.samples(i));
    kept.parts.front().end = settings.firstSample + int64_t(most);
    RenderStatistics soFar = position.statistics;
    soFar.samples = kept.film.totalSamples();
    kept.metadata = metadataOf({loaded, soFar, settings.seed, kept.classes, "recurse render " + optionsText,
                                kept.film.bounds().width(), kept.film.bounds().height()});
    try {
      writeCheckpoint(plan.checkpoint, kept);
      failure.clear();
    } catch (const Error& error) { // the render goes on without its checkpoint
      if (failure.empty()) display.message(std::string("warning: ") + error.what());
      failure = error.what();
    }
  }

  void renderFirst(double timeLimit) {
    first = renderFirstPicture(loaded, *firstClasses, settings.seed, timeLimit, graceful->flag(), show);
  }
  void beginLooking() {
    settings.look = [this] { return plan.look([this] { return grownPicture(); }, log); };
    if (firstClasses && kept.film.totalSamples() == 0) {
      renderFirst(settings.timeLimit);
      // The time limit includes the first picture.
      if (settings.timeLimit > 0)
        settings.timeLimit = std::max(settings.timeLimit - first->statistics.renderSeconds, NO_TIME_LEFT);
    }
    if (first || kept.film.totalSamples() > 0) settings.lookAfter = settings.look();
  }
  /** Picture of the film; pixels without a sample have the first picture's value. */
  Image grownPicture() {
    const auto pictureIn = [&](const Film& film) {
      return pictureOf(film, kept.classes, kept.imagingRatio, {});
    };
    Image image = pictureIn(kept.film);
    if (!first) return image;
    const Image before = pictureIn(first->film);
    const size_t channels = image.channels.size();
    bool isComplete = true;
    for (size_t pixel = 0; pixel < kept.film.bounds().area(); ++pixel) {
      if (kept.film.samples(pixel) > 0) continue;
      isComplete = false;
      std::copy_n(&before.pixels[pixel * channels], channels, &image.pixels[pixel * channels]);
    }
    if (isComplete) first.reset();
    return image;
  }

  /** Warning on light that the integrator does not find; empty if there is none. */
  std::string missedText() const {
    const std::string missed = missedPaths(loaded, kept.classes);
    if (missed.empty()) return {};
    return "light of point, spot and distant lights is missing (" + missed + "): '" +
           loaded.integratorDirective.type + "' cannot find it; use --integrator photonmap";
  }
  void render() {
    settings.allocation = kept.allocation ? &*kept.allocation : nullptr;
    const auto renderBy = [&](const auto& way) {
      return way(*loaded.scene, *loaded.integrator, classes, settings, kept.film, graceful->flag(), show,
                 log);
    };
    statistics = cluster() ? renderBy([](auto&&... arguments) { return cluster()->render(arguments...); })
                           : renderBy([](auto&&... arguments) { return recurse::render(arguments...); });
  }

  bool isInterrupted() const { return statistics.stopReason == StopReason::INTERRUPTED; }
  /** Ensures that there is a picture, or throws Error; warns of missing light. */
  void complete(const std::string& missed) {
    if (!missed.empty()) statistics.warnings.push_back(missed);
    if (plan.endsWithFirstPicture && firstClasses && statistics.samples == 0) {
      if (!first && !isInterrupted()) renderFirst(NO_TIME_LEFT);
      if (first && first->statistics.samples > 0) takeFirstPicture();
    }
    if (isInterrupted() && statistics.samples == 0)
      throw Error("interrupted before the first sample: nothing was written", ExitStatus::INTERRUPTED);
    if (statistics.samples == 0)
      throw Error("no sample was ready in time: nothing was written. Increase --time-limit");
  }
  /** Replaces a film without samples by the first picture, with a warning. */
  void takeFirstPicture() {
    const RenderStatistics ended = std::exchange(statistics, first->statistics);
    isFirst = true;
    statistics.stopReason = ended.stopReason;
    statistics.renderSeconds += ended.renderSeconds;
    statistics.processorSeconds += ended.processorSeconds;
    statistics.learningProcessorSeconds += ended.learningProcessorSeconds;
    statistics.photonProcessorSeconds += ended.photonProcessorSeconds;
    warn((isInterrupted() ? "interrupted" : "time limit reached") + std::string(" before ") +
         loaded.integratorDirective.type +
         " had one sample of every pixel: this picture is a path-traced preview with 1 sample per pixel" +
         (isInterrupted() ? "" : "; increase --time-limit, or choose --integrator path"));
  }
  void warn(const std::string& text) {
    statistics.warnings.push_back(text);
    log("warning: " + text);
  }

  const LoadedScene& loaded;
  const PathClasses& classes;
  const RenderPlan& plan;
  const RenderOptions& options;
  RenderSettings settings;
  ProgressDisplay display;
  const std::function<void(const std::string&)> log;
  const std::function<void(const RenderProgress&)> show;
  const std::string optionsText;
  std::unique_ptr<const GracefulStop> graceful = std::make_unique<const GracefulStop>();
  std::unique_ptr<const FileLock> lock; ///< of the checkpoint, which no other process may replace now
  Checkpoint kept;
  const std::optional<PathClasses> firstClasses;
  std::optional<FirstPicture> first; ///< kept until every pixel has a sample
  bool isFirst = false;              ///< `first` has replaced the picture
  RenderStatistics statistics;
  std::string failure;
};

} // namespace

void RenderResult::explainBlackness() {
  if (isInterrupted() || statistics.least == 0 || !missedPaths(loaded, classes).empty()) return;
  const bool isOvertime = statistics.stopReason == StopReason::TIME;
  std::vector<PathClass> whole = classes;
  whole.resize(classes.size() - frames.layerCount());
  const std::string why =
      blackPictureText(loaded, sceneClasses(whole, *loaded.scene, loaded.integrator.get()), film, stopFlag(),
                       isOvertime ? PROBE_SECONDS_OVERTIME : PROBE_SECONDS);
  if (why.empty()) return;
  statistics.warnings.push_back(why);
  say("warning: " + why + "\n");
}

RenderReport RenderResult::report(const std::string& command, const std::string& rest) const {
  return {loaded,
          statistics,
          seed,
          classes,
          command + " " + optionsText + rest,
          film.bounds().width(),
          film.bounds().height()};
}

RenderResult renderLoaded(const LoadedScene& loaded, const PathClasses& classes, const RenderPlan& plan,
                          const RenderOptions& options, const Retell& retell) {
  return RenderRun(loaded, classes, plan, options, retell).run();
}

} // namespace recurse::apps
