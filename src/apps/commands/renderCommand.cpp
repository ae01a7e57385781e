/** @file
 * `recurse render`: pictures of a scene file.
 */
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <optional>

#include "apps/commands/commands.h"
#include "apps/load/sentScene.h"
#include "apps/options/optionText.h"
#include "apps/options/renderCommandOptions.h"
#include "apps/run/blackPicture.h"
#include "apps/run/cluster.h"
#include "apps/run/firstPicture.h"
#include "apps/run/watch.h"
#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/files.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/render/featureLayers.h"
#include "recurse/transport/integrator/sceneNames.h"

namespace recurse::apps {

namespace {

/** Default output: the film's file name, in the current folder as in pbrt. Without one: an .exr, which keeps
 * everything, with the name of the scene. A scene cannot choose other folders: of a name that leads out of
 * the current folder, only the last component is used. */
std::string defaultOutput(const LoadedScene& loaded) {
  std::filesystem::path name = loaded.scene->film().fileName;
  if (name.empty()) name = std::filesystem::path(loaded.fileName).stem();
  if (name.extension().empty()) name += ".exr";
  if (isInside(name.string(), ".")) return name.string();
  const std::string last = name.filename().string();
  if (name.has_parent_path()) {
    say("warning: the scene file sets the picture file " + name.string() + "; instead it is written to " +
        last + " in the current folder; choose another place with -o\n");
    if (isInside(last, ".")) return last;
  }
  badUsage(last +
           ": is a link to a place outside of the current folder; choose a place for the picture with -o");
}

using OnLoaded = std::function<void(const std::vector<std::string>& files)>;

/** Loads the scene, or the copy that the leading process sends. */
LoadedScene loadNow(const RenderCommandOptions& o, const RenderPlan& plan) {
  const LoadOverrides& overrides = plan.overrides;
  if (!o.sendScene) return loadAndBuild(o.render.scene, overrides, o.render.integrator, o.reduction, o.frame);
  if (!cluster()) badUsage("--send-scene: works with recurse-mpi only");
  if (!cluster()->leads()) {
    const auto received = std::make_shared<const ReceivedScene>(*cluster());
    LoadedScene loaded = loadAndBuild(received->fileName(), overrides, o.render.integrator);
    loaded.place = received; // textures are read while it renders
    return loaded;
  }
  std::optional<LoadedScene> loaded;
  try {
    loaded = loadAndBuild(o.render.scene, overrides, o.render.integrator);
  } catch (...) {
    sendNoScene(*cluster());
    throw;
  }
  sendScene(*cluster(), *loaded);
  return std::move(*loaded);
}

/** Loads the scene within the time limit, which ends the program unless it watches the scene. */
LoadedScene load(const RenderCommandOptions& o, const RenderPlan& plan) {
  using TimeLimit = NothingToWrite::TimeLimit;
  const NothingToWrite loading(plan.timeLimit, o.watch ? TimeLimit::WORK : TimeLimit::PROGRAM);
  try {
    return loadNow(o, plan);
  } catch (const Error&) {
    if (!loading.timeIsUp()) throw;
    throw Error(NOT_LOADED_IN_TIME);
  }
}

/** File name of a frame: its number replaces the last '#'s, or else precedes the extension. */
std::string numberedName(const std::string& name, int frame) {
  constexpr size_t DIGITS = 4;
  const std::filesystem::path path = name;
  std::string file = path.filename().string(), number = std::to_string(frame);
  const size_t end = file.find_last_of('#');
  if (end == std::string::npos) {
    number.insert(0, DIGITS - std::min(DIGITS, number.size()), '0');
    file = path.stem().string() + "-" + number + path.extension().string();
  } else {
    size_t begin = end;
    while (begin > 0 && file[begin - 1] == '#') --begin;
    const size_t digits = end + 1 - begin;
    number.insert(0, digits - std::min(digits, number.size()), '0');
    file.replace(begin, digits, number);
  }
  return (path.parent_path() / file).string();
}

/** Reports the parts that a frame reuses, and releases the scene of the previous frame. */
void startFrame(AnimationFrame& frame, const std::shared_ptr<const LoadedScene>& loaded,
                const RenderCommandOptions& o) {
  if (loaded->description.tracks.empty())
    badUsage("--frames: " + o.render.scene + " has no Animate directive, so all frames are equal");
  if (!o.render.quiet) {
    std::string kept;
    const auto add = [&kept](const auto& parts, const char* what) {
      const size_t all = parts.kept + parts.made;
      if (parts.kept > 0)
        kept += (kept.empty() ? "; as before: " : ", ") + std::to_string(parts.kept) + " of " +
                std::to_string(all) + " " + what;
    };
    add(frame.kept.models, "models");
    add(frame.kept.shapes, "shapes");
    add(frame.kept.trees, "objects' trees");
    add(frame.kept.media, "media");
    say("frame " + std::to_string(frame.number) + ": built in " +
        durationText(loaded->loadSeconds + loaded->buildSeconds) + kept + "\n");
  }
  frame.isFirst = !frame.before;
  frame.before = loaded;
}

/** Suggests a different integrator, if the scene file names a path tracer and the options name none. */
std::string integratorRemark(const RenderOptions& options, const LoadedScene& loaded) {
  const std::string& type = loaded.description.integrator.type;
  if (options.integrator.named() || (type != "path" && type != "volpath")) return "";
  return "the scene uses the integrator \"" + type +
         "\"; --integrator auto often has less noise in the same time\n";
}

/** Output files of the picture; none if a range of samples goes into a checkpoint only. */
std::vector<std::string> outputsOf(const RenderCommandOptions& o, const LoadedScene& loaded) {
  if (!o.outputs.empty() || (o.sampleRange && !o.checkpoint.empty())) return o.outputs;
  const std::string name = defaultOutput(loaded);
  return {o.frame && !isAnimationFormat(name) ? numberedName(name, o.frame->number) : name};
}

/** Keeps the errors of single files until all files have been tried. */
class Attempts {
 public:
  /** Calls write(). False if it threw an Error. */
  bool attempt(const std::function<void()>& write) {
    try {
      write();
      return true;
    } catch (const Error& error) {
      failures += (failures.empty() ? "" : "\nrecurse: ") + std::string(error.what());
      return false;
    }
  }
  void throwFailures() const {
    if (!failures.empty()) throw Error(failures);
  }

 private:
  std::string failures;
};

RenderReport reportOf(const RenderResult& result, const RenderCommandOptions& o) {
  RenderReport report = result.report(
      "recurse render", o.pathsText() + (o.frame ? " --frames " + std::to_string(o.frame->number) : ""));
  report.extra = o.extra;
  return report;
}

/** Writes the requested files, and prints the summary of the render. False if the render or its feature
 * layers were interrupted. */
bool writeResults(RenderResult& result, const RenderCommandOptions& o,
                  const std::vector<std::string>& outputs, const FeatureSettings& features,
                  PictureWriter& writer, FilmViewers& viewers) {
  std::optional<double> animationStops;
  const RenderReport report = reportOf(result, o);
  Image image = pictureOf(result.film, report);
  const bool isComplete = addFeatures(image, report.loaded, features, result.stopFlag());
  Attempts files;
  std::vector<std::string> written;
  const auto writePicture = [&](const std::string& name) {
    if (files.attempt([&] { writer.write(name, image); })) written.push_back(name);
  };
  const auto writeAnimation = [&](const std::string& name) {
    if (o.animations)
      o.animations->add(name, writer.developedPicture(image));
    else if (files.attempt([&] {
               animationStops = writeTransientAnimation(name, image, o.develop, parseFrameRate(o.frameRate));
             }))
      written.push_back(name);
  };
  for (const std::string& name : outputs) o.isAnimation(name) ? writeAnimation(name) : writePicture(name);
  if (o.frame && !o.frame->stops) o.frame->stops = writer.stops();
  viewers.finish(image, [](const std::string& text) { say(text + "\n"); });
  if (!o.viewers.preview.empty()) writePicture(o.viewers.preview);
  result.explainBlackness();
  if (!o.render.statistics.empty() &&
      files.attempt([&] { writeFileAtomically(o.render.statistics, statisticsJson(report)); }))
    written.push_back(o.render.statistics);
  if (!o.render.quiet)
    say(renderSummary(report, written, !o.render.verbose) + integratorRemark(o.render, report.loaded) +
        writer.remark(animationStops));
  if (!result.checkpointFailure.empty()) files.attempt([&] { throw Error(result.checkpointFailure); });
  files.throwFailures();
  return isComplete && !result.isInterrupted();
}

std::string titleOf(const RenderCommandOptions& o) {
  return std::filesystem::path(o.render.scene).filename().string();
}

/** Lets the live page ask for the paths of pixels. */
void answerPixels(const std::shared_ptr<const LoadedScene>& loaded, const PathClasses& classes,
                  const std::string& title, FilmViewers& viewers, RenderPlan& plan) {
  const auto queries = std::make_shared<PixelQueries>(
      std::shared_ptr<const Scene>(loaded, loaded->scene.get()), classes, title,
      loaded->integratorDirective.type + ", during the render", maxDepthOf(loaded->integratorDirective),
      plan.settings(*loaded->scene).seed);
  viewers.answerPixels(queries);
  plan.isAsked = [queries] { return queries->isAsked(); };
  plan.answer = [queries](const RenderPause& pause) { queries->answer(pause); };
}

ExitStatus renderScene(const RenderCommandOptions& given, const OnLoaded& onLoaded = {}) {
  const bool leads = !cluster() || cluster()->leads();
  RenderCommandOptions o = leads ? given : given.withoutOutputs();
  if (o.frame && o.frame->stops) o.develop.exposure = formatted("%.17g", *o.frame->stops);
  RenderPlan plan = o.plan();
  PictureWriter writer(o.develop);
  o.pathClasses(); // reports errors before the scene is loaded
  parseFrameRate(o.frameRate);
  o.checkOutputs(o.outputs);
  const ThreadPool pool(plan.threads > 0 || !cluster() ? plan.threads : cluster()->threads());
  const auto held = std::make_shared<const LoadedScene>(load(o, plan));
  const LoadedScene& loaded = *held;
  const PathClasses classes = o.pathClasses(loaded);
  if (onLoaded) onLoaded(loaded.files);
  o.checkIntegrator(loaded);
  if (o.frame) startFrame(*o.frame, held, o);
  if (o.check) {
    if (o.frame && !o.frame->isFirst) return ExitStatus::DONE;
    print(sceneReport(loaded, classes.layerCount()));
    if (const std::string why = darknessReason(loaded); !why.empty())
      say("warning: the picture will be black: " + why + "\n");
    return ExitStatus::DONE;
  }
  const std::vector<std::string> outputs = outputsOf(o, loaded);
  if (leads) {
    o.checkOutputs(outputs);
    o.keepInputs(outputs, loaded.files);
  }
  const FeatureSettings features = o.features(outputs, leads && loaded.scene->film().layered);
  requireFeatureLayers(features.layers, *loaded.integrator);

  FilmViewers viewers(o.viewers, o.develop, titleOf(o), requestStop);
  if (o.viewers.any())
    plan.look = [&](const auto& picture, const auto& say) { return viewers.look(picture, say); };
  if (o.viewers.live && !cluster()) answerPixels(held, classes, titleOf(o), viewers, plan);
  plan.endsWithFirstPicture = true;
  RenderResult result = renderLoaded(loaded, classes, plan, o.render,
                                     [&](const RenderProgress& progress) { viewers.show(progress); });
  if (!leads) return ExitStatus::DONE;
  return writeResults(result, o, outputs, features, writer, viewers) ? ExitStatus::DONE
                                                                     : ExitStatus::INTERRUPTED;
}

/** Renders the frames in sequence, on one live page; stops at an interrupted frame. */
ExitStatus renderFrames(const RenderCommandOptions& given, const OnLoaded& onLoaded = {}) {
  for (const auto& [isGiven, option] : {std::pair(!given.checkpoint.empty(), "--checkpoint"),
                                        std::pair(given.sampleRange.has_value(), "--sample-range"),
                                        std::pair(given.sendScene, "--send-scene")})
    if (isGiven) badUsage(std::string("--frames: cannot be combined with ") + option);
  constexpr int64_t LAST_FRAME = 9999999;
  const std::vector<std::string> range = split(given.frames, ':');
  if (range.size() > 2)
    badUsage("--frames: '" + given.frames +
             "' is neither FIRST:LAST, such as 0:48, nor the number of a frame");
  const int64_t first = parseCount("--frames", range.front(), 0, LAST_FRAME);
  const int64_t last = parseCount("--frames", range.back(), first, LAST_FRAME);
  AnimationFrame frame;
  AnimationFiles animations(parseFrameRate(given.frameRate));
  ViewerOptions viewers = given.viewers;
  const bool ownsPage = !viewers.page && (!cluster() || cluster()->leads());
  if (ownsPage) viewers.page = viewers.openPage(titleOf(given), requestStop);
  ExitStatus status = ExitStatus::DONE;
  for (int64_t n = first; n <= last && status == ExitStatus::DONE; ++n) {
    RenderCommandOptions o = given;
    o.viewers = viewers;
    frame.number = static_cast<int>(n);
    o.frame = &frame;
    o.animations = &animations;
    for (std::string& name : o.outputs)
      if (!isAnimationFormat(name)) name = numberedName(name, frame.number);
    if (!o.render.statistics.empty()) o.render.statistics = numberedName(o.render.statistics, frame.number);
    status = renderScene(o, onLoaded);
  }
  Attempts files;
  for (const std::string& name : animations.names())
    if (files.attempt([&] { animations.write(name); }) && !given.render.quiet) say("written: " + name + "\n");
  if (ownsPage && viewers.page) viewers.page->finish(viewers.patience);
  files.throwFailures();
  return status;
}

/** Renders picture or frames whenever the scene changes: first at a quarter of width and height, then in
 * full. One live page shows all renders; its button ends the current one, until the next change. */
ExitStatus renderAgainAndAgain(const RenderCommandOptions& given) {
  if (cluster()) badUsage("--watch: works in one process only");
  for (const auto& [isGiven, option] :
       {std::pair(given.check, "--check"), std::pair(!given.checkpoint.empty(), "--checkpoint"),
        std::pair(given.sampleRange.has_value(), "--sample-range"),
        std::pair(given.sendScene, "--send-scene")})
    if (isGiven) badUsage(std::string("--watch: cannot be combined with ") + option);
  constexpr int FIRST_REDUCTION = 4;
  std::atomic<bool> isRendering{false}, isStoppedByPage{false};
  RenderCommandOptions o = given;
  o.viewers.check();
  o.viewers.page = o.viewers.openPage(titleOf(o), [&] {
    if (!isRendering) return;
    isStoppedByPage = true;
    requestStop();
  });
  bool skipsFull = false;
  const auto end = [&] {
    isRendering = false;
    skipsFull = isStoppedByPage.exchange(false);
    if (skipsFull) withdrawStop();
  };
  return watchScene(given.render.scene, [&](bool first, const OnLoaded& onLoaded) {
    o.reduction = first ? FIRST_REDUCTION : 1;
    try {
      isRendering = true;
      if (first || !skipsFull) o.frames.empty() ? renderScene(o, onLoaded) : renderFrames(o, onLoaded);
    } catch (...) {
      end();
      throw;
    }
    end();
    if (o.viewers.page && (!first || skipsFull)) o.viewers.page->finish(o.viewers.patience);
  });
}

} // namespace

void addRenderCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<RenderCommandOptions>();
  CLI::App* command = app.add_subcommand("render", "Render a scene file to pictures");
  options->addTo(*command);
  command->callback([options, &chosen] {
    chosen = [options] {
      if (options->watch) return renderAgainAndAgain(*options);
      return options->frames.empty() ? renderScene(*options) : renderFrames(*options);
    };
  });
}

} // namespace recurse::apps
