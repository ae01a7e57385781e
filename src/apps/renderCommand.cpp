/** @file
 * `recurse render`: a scene file in, pictures out.
 */
#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include "apps/cluster.h"
#include "apps/commands.h"
#include "apps/developOptions.h"
#include "apps/filmViewers.h"
#include "apps/optionText.h"
#include "apps/renderOptions.h"
#include "apps/sentScene.h"
#include "apps/watch.h"
#include "recurse/core/atomicFile.h"
#include "recurse/core/parallel.h"
#include "recurse/transport/featureLayers.h"

namespace recurse::apps {

namespace {

struct RenderCommandOptions {
  RenderOptions render;
  std::vector<std::string> outputs;
  DevelopOptions develop;
  std::optional<std::string> sampleRange, checkpointInterval;
  std::string paths, checkpoint, layers;
  ViewerOptions viewers;
  bool resume = false, throughSpecular = false;
  ExtraLayers extra;
  bool check = false, watch = false, sendScene = false;
  std::string frames;
  AnimationFrame* frame = nullptr; ///< of an animation
  int reduction = 1;               ///< what width and height of the picture are divided by
};

void checkOutputs(const RenderCommandOptions& o, const std::vector<std::string>& outputs) {
  std::set<std::string> names;
  for (const std::string& name : outputs) {
    checkImageWritable(name);
    if (!names.insert(name).second) throw Error("-o: " + name + " is given twice", ExitStatus::BAD_USAGE);
  }
  o.viewers.check();
  if (names.contains(o.viewers.preview)) badUsage("--preview: " + o.viewers.preview + " is what -o writes");
  if (!o.render.statistics.empty()) checkFileWritable(o.render.statistics);
  if (o.checkpoint.empty()) return;
  if (!o.resume && std::filesystem::exists(o.checkpoint))
    throw Error("--checkpoint: " + o.checkpoint + " exists; go on with it by --resume, or remove it",
                ExitStatus::BAD_USAGE);
  checkFileWritable(o.checkpoint);
}

/** What --checkpoint and its relatives say. */
RenderPlan planOf(const RenderCommandOptions& o) {
  RenderPlan plan = o.render.plan();
  plan.checkpoint = o.checkpoint;
  plan.resume = o.resume;
  const auto needsCheckpoint = [&](bool given, const char* option) {
    if (given && o.checkpoint.empty())
      throw Error(std::string(option) + ": needs --checkpoint FILE", ExitStatus::BAD_USAGE);
  };
  needsCheckpoint(o.resume, "--resume");
  needsCheckpoint(o.checkpointInterval.has_value(), "--checkpoint-interval");
  if (o.checkpointInterval)
    plan.checkpointInterval = parseDuration("--checkpoint-interval", *o.checkpointInterval);
  if (!o.sampleRange) return plan;
  if (plan.adaptive)
    throw Error(
        "--sample-range: with --adaptive the number of samples follows from those before; other parts "
        "of a picture are other seeds (--seed)",
        ExitStatus::BAD_USAGE);
  const std::vector<std::string> range = split(*o.sampleRange, ':');
  if (range.size() != 2)
    throw Error("--sample-range: '" + *o.sampleRange + "' is not FIRST:END, such as 64:128",
                ExitStatus::BAD_USAGE);
  if (!plan.samples)
    throw Error("--sample-range: needs --spp N, the number of samples of which these are a part",
                ExitStatus::BAD_USAGE);
  plan.firstSample = parseCount("--sample-range", range[0], 0, *plan.samples - 1);
  plan.endSample = parseCount("--sample-range", range[1], plan.firstSample + 1, *plan.samples);
  return plan;
}

/** Checks --layers before the render. `layered`: the scene's film asks for layers. */
FeatureSettings featuresOf(const RenderCommandOptions& o, const std::vector<std::string>& outputs,
                           bool layered) {
  FeatureSettings out;
  out.throughSpecular = o.throughSpecular;
  const bool hasExr =
      std::any_of(outputs.begin(), outputs.end(), [](const auto& name) { return name.ends_with(".exr"); });
  if (!o.layers.empty()) {
    out.layers = split(o.layers, ',');
    requireFeatureLayers(out.layers);
    if (!hasExr) badUsage("--layers: only .exr can hold them; add -o FILE.exr");
  } else if (layered && hasExr) { // as far as pbrt has them too
    for (const FeatureLayer& layer : featureLayers())
      if (*layer.channels) out.layers.emplace_back(layer.name);
  } else if (o.throughSpecular) {
    badUsage("--layers-through: needs --layers");
  }
  return out;
}

/** The film's file name, in the current folder as pbrt has it; a picture with everything where it says
 * nothing. */
std::string defaultOutput(const LoadedScene& loaded) {
  std::filesystem::path name = loaded.scene->film().fileName;
  if (name.empty()) name = std::filesystem::path(loaded.fileName).stem();
  if (name.extension().empty()) name += ".exr";
  return name.string();
}

/** What is left of the options for a process that does not lead. */
RenderCommandOptions withoutOutputs(RenderCommandOptions o) {
  planOf(o); // what is wrong with them is wrong for all
  o.outputs.clear();
  o.checkpoint.clear();
  o.checkpointInterval.reset();
  o.resume = false;
  o.viewers = {};
  o.layers.clear();
  o.throughSpecular = false;
  o.render.statistics.clear();
  o.render.progress = "off";
  o.render.quiet = true;
  o.render.verbose = false;
  return o;
}

using OnLoaded = std::function<void(const std::vector<std::string>& files)>;

/** Of the scene, or of what the leading process sends. */
LoadedScene load(const RenderCommandOptions& o, const SceneOverrides& overrides) {
  if (!o.sendScene) return loadAndBuild(o.render.scene, overrides, o.render.integrator, o.reduction, o.frame);
  if (!cluster()) badUsage("--send-scene: for recurse-mpi");
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

/** The name of a frame's file: its number in the place of the last '#'s, else before the extension. */
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

/** Tells what a frame took from the one before, whose scene is not needed any more. */
void startFrame(AnimationFrame& frame, const std::shared_ptr<const LoadedScene>& loaded,
                const RenderCommandOptions& o) {
  if (loaded->description.tracks.empty())
    badUsage("--frames: " + o.render.scene + " has no Animate directive, so that all frames are the same");
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
    std::fputs(("frame " + std::to_string(frame.number) + ": built in " +
                durationText(loaded->loadSeconds + loaded->buildSeconds) + kept + "\n")
                   .c_str(),
               stderr);
  }
  frame.isFirst = !frame.before;
  frame.before = loaded;
}

/** What to try where the file names a path tracer, as most public scenes do, and the command line nothing. */
std::string integratorRemark(const RenderOptions& options, const LoadedScene& loaded) {
  const std::string& type = loaded.description.integrator.type;
  if (options.integrator.named() || (type != "path" && type != "volpath")) return "";
  return "the scene asks for \"" + type +
         "\"; --integrator photonmap often has less noise in the same time\n";
}

/** The files for the picture; none where a part of the samples goes into a checkpoint alone. */
std::vector<std::string> outputsOf(const RenderCommandOptions& o, const LoadedScene& loaded) {
  if (!o.outputs.empty() || (o.sampleRange && !o.checkpoint.empty())) return o.outputs;
  const std::string name = defaultOutput(loaded);
  return {o.frame ? numberedName(name, o.frame->number) : name};
}

/** Keeps the errors of single files until all others are written. */
class Attempts {
 public:
  /** False when it failed. */
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

RenderReport reportOf(const Rendering& rendering, const RenderCommandOptions& o) {
  RenderReport report =
      rendering.report("recurse render", (o.paths.empty() ? "" : " --paths " + shellQuoted(o.paths)) +
                                             (o.frame ? " --frames " + std::to_string(o.frame->number) : ""));
  report.extra = o.extra;
  return report;
}

/** Writes the files that were asked for, and sums the render up. */
void writeResults(const Rendering& rendering, const RenderCommandOptions& o,
                  const std::vector<std::string>& outputs, const FeatureSettings& features,
                  PictureWriter& writer, FilmViewers& viewers) {
  const RenderReport report = reportOf(rendering, o);
  Image image = pictureOf(rendering.film(), report);
  if (!features.layers.empty()) image = withChannels(image, renderFeatures(*report.loaded.scene, features));
  Attempts files;
  std::vector<std::string> written;
  const auto writePicture = [&](const std::string& name) {
    if (files.attempt([&] { writer.write(name, image); })) written.push_back(name);
  };
  for (const std::string& name : outputs) writePicture(name);
  viewers.finish(image, [](const std::string& text) { std::fputs((text + "\n").c_str(), stderr); });
  if (!o.viewers.preview.empty()) writePicture(o.viewers.preview);
  if (!o.render.statistics.empty() &&
      files.attempt([&] { writeFileAtomically(o.render.statistics, statisticsJson(report)); }))
    written.push_back(o.render.statistics);
  if (!o.render.quiet)
    std::fputs((renderSummary(report, written, !o.render.verbose) +
                integratorRemark(o.render, report.loaded) + writer.remark())
                   .c_str(),
               stderr);
  if (!rendering.checkpointFailure().empty())
    files.attempt([&] { throw Error(rendering.checkpointFailure()); });
  files.throwFailures();
}

ExitStatus renderScene(const RenderCommandOptions& given, const OnLoaded& onLoaded = {}) {
  const bool leads = !cluster() || cluster()->leads();
  const RenderCommandOptions o = leads ? given : withoutOutputs(given);
  RenderPlan plan = planOf(o);
  PictureWriter writer(o.develop);
  const PathClasses classes =
      o.paths.empty() ? PathClasses() : PathClasses(std::vector<PathClass>{{o.paths, o.paths}});
  checkOutputs(o, o.outputs);
  const ThreadPool pool(plan.threads > 0 || !cluster() ? plan.threads : cluster()->threads());
  const auto held = std::make_shared<const LoadedScene>(load(o, plan.overrides));
  const LoadedScene& loaded = *held;
  if (onLoaded) onLoaded(loaded.files);
  if (o.frame) startFrame(*o.frame, held, o);
  if (o.check) {
    if (!o.frame || o.frame->isFirst) print(sceneReport(loaded, classes.layerCount()));
    return ExitStatus::DONE;
  }
  const std::vector<std::string> outputs = outputsOf(o, loaded);
  if (leads) checkOutputs(o, outputs);
  const FeatureSettings features = featuresOf(o, outputs, leads && loaded.scene->film().layered);

  FilmViewers viewers(o.viewers, o.develop, std::filesystem::path(o.render.scene).filename().string(),
                      requestStop);
  if (!viewers.url().empty())
    std::fputs(("the picture as it grows: " + viewers.url() + "\n").c_str(), stderr);
  if (o.viewers.any())
    plan.look = [&](const Film& film, const std::function<void(const std::string&)>& say) {
      const float imagingRatio = loaded.scene->film().imagingRatio;
      return viewers.look([&] { return pictureOf(film, classes.classes(), imagingRatio, {}); }, say);
    };
  const Rendering rendering(loaded, classes, plan, o.render,
                            [&](const RenderProgress& progress) { viewers.show(progress); });
  if (!leads) return ExitStatus::DONE;
  writeResults(rendering, o, outputs, features, writer, viewers);
  return rendering.interrupted() ? ExitStatus::INTERRUPTED : ExitStatus::DONE;
}

/** Renders at a quarter of the width and height, then in full, whenever the scene changes. */
ExitStatus renderAgainAndAgain(const RenderCommandOptions& given) {
  if (cluster()) badUsage("--watch: one process only");
  for (const auto& [isGiven, option] :
       {std::pair(given.check, "--check"), std::pair(!given.checkpoint.empty(), "--checkpoint"),
        std::pair(given.sampleRange.has_value(), "--sample-range"), std::pair(given.viewers.live, "--live")})
    if (isGiven) badUsage(std::string("--watch: not together with ") + option);
  constexpr int FIRST_REDUCTION = 4;
  return watchScene(given.render.scene, [&](bool first, const OnLoaded& onLoaded) {
    RenderCommandOptions o = given;
    o.reduction = first ? FIRST_REDUCTION : 1;
    renderScene(o, onLoaded);
  });
}

/** One picture after the other; stops where one is interrupted. */
ExitStatus renderFrames(const RenderCommandOptions& given) {
  for (const auto& [isGiven, option] :
       {std::pair(given.watch, "--watch"), std::pair(!given.checkpoint.empty(), "--checkpoint"),
        std::pair(given.sampleRange.has_value(), "--sample-range"), std::pair(given.viewers.live, "--live"),
        std::pair(given.sendScene, "--send-scene")})
    if (isGiven) badUsage(std::string("--frames: not together with ") + option);
  constexpr int64_t LAST_FRAME = 9999999;
  const std::vector<std::string> range = split(given.frames, ':');
  if (range.size() > 2)
    badUsage("--frames: '" + given.frames + "' is not FIRST:LAST, such as 0:48, nor one frame's number");
  const int64_t first = parseCount("--frames", range.front(), 0, LAST_FRAME);
  const int64_t last = parseCount("--frames", range.back(), first, LAST_FRAME);
  AnimationFrame frame;
  for (int64_t n = first; n <= last; ++n) {
    RenderCommandOptions o = given;
    frame.number = static_cast<int>(n);
    o.frame = &frame;
    for (std::string& name : o.outputs) name = numberedName(name, frame.number);
    if (!o.render.statistics.empty()) o.render.statistics = numberedName(o.render.statistics, frame.number);
    if (const ExitStatus status = renderScene(o); status != ExitStatus::DONE) return status;
  }
  return ExitStatus::DONE;
}

constexpr const char* EXAMPLES =
    "Examples:\n"
    "  recurse render scene.pbrt -o picture.exr -o picture.png\n"
    "  recurse render scene.pbrt -o quick.png --time-limit 30s --resolution 320x240\n"
    "  recurse render scene.pbrt -o truth.exr --integrator path --spp 1024\n"
    "  recurse render scene.pbrt -o sure.exr --integrator path --error-target 0.05\n"
    "  recurse render scene.pbrt -o even.exr --integrator path --spp 256 --adaptive --samples-layer\n"
    "  recurse render scene.pbrt -o fine.exr --photons 10M --spp 64 --stats fine.json\n"
    "  recurse render scene.pbrt -o caustics.exr --paths 'LS+DE'\n"
    "  recurse render scene.pbrt -o bright.png --exposure auto+1 --tonemap reinhard\n"
    "  recurse render scene.pbrt -o plain.png --exposure 0 --tonemap none\n"
    "  recurse render scene.pbrt -o long.exr --spp 4096 --checkpoint long.rck --resume\n"
    "  recurse render scene.pbrt -o half.exr --spp 512 --sample-range 0:256 --checkpoint a.rck\n"
    "  recurse render scene.pbrt -o layers.exr --layers albedo,normal,depth\n"
    "  recurse render scene.pbrt -o long.exr --spp 4096 --live\n"
    "  recurse render scene.pbrt -o long.exr --spp 4096 --preview look.png --every 30s\n"
    "  recurse render scene.pbrt -o look.png --watch --time-limit 20s\n"
    "  recurse render scenes/animation.pbrt --frames 0:48 -o film.png\n"
    "  recurse render scene.pbrt --check\n\n"
    "Ctrl-C writes what there is; twice gives up at once. A file that exists is replaced only by a\n"
    "complete one.";

void addCheckpointOptions(CLI::App& command, RenderCommandOptions& o) {
  command
      .add_option("--checkpoint", o.checkpoint,
                  "Keep the render in this file, every now and then and at its end or interruption")
      ->type_name("FILE");
  command.add_option("--checkpoint-interval", o.checkpointInterval, "How often that is done (default: 60s)")
      ->type_name("TIME");
  command.add_flag("--resume", o.resume,
                   "Go on with the render in the --checkpoint file, bit for bit as if it had never stopped; "
                   "begin where there is no such file");
  command
      .add_option(
          "--sample-range", o.sampleRange,
          "Only the samples FIRST to END-1 of the --spp of each pixel; 'recurse merge' adds renders up")
      ->type_name("FIRST:END");
}

void addLayerOptions(CLI::App& command, RenderCommandOptions& o) {
  command.add_flag("--error-layer", o.extra.error,
                   "Add the standard error of each pixel's luminance to .exr, as channel error.Y");
  command.add_flag("--samples-layer", o.extra.samples,
                   "Add the number of samples of each pixel to .exr, as channel samples.N");
  command
      .add_option(
          "--layers", o.layers,
          "Add features of what the pixels see to .exr: albedo, normal (shading, towards the viewer), "
          "geonormal (of the surface itself), depth (distance), position (in world space), cryptoobject and "
          "cryptomaterial (mattes by the Cryptomatte convention)")
      ->type_name("NAME,NAME...");
  command.add_flag("--layers-through", o.throughSpecular,
                   "For --layers: of what is seen in mirrors and through smooth glass");
}

void addRepetitionOptions(CLI::App& command, RenderCommandOptions& o) {
  command.add_flag(
      "--watch", o.watch,
      "Render again when a file of the scene changes, at a quarter of the width and height first, "
      "until Ctrl-C");
  command
      .add_option(
          "--frames", o.frames,
          "Frames of a scene with Animate directives, FIRST to LAST inclusive or one alone, each a picture: "
          "'-o film.png' writes film-0000.png and so on, '-o film##.png' film00.png. The exposure of .png is "
          "chosen for each: --exposure 0 keeps it. Files that are read, "
          "shapes and objects that do not change are not built again; lights, materials and the tree over "
          "all are. A --time-limit holds for each frame")
      ->type_name("FIRST:LAST");
}

} // namespace

void addRenderCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<RenderCommandOptions>();
  RenderCommandOptions& o = *options;
  CLI::App* command = app.add_subcommand("render", "Render a scene file to pictures");
  o.render.addSceneTo(*command);
  command
      ->add_option(
          "-o,--output", o.outputs,
          "Picture to write, several allowed: .exr with everything, .hdr and .pfm linear, .png .jpg .tif "
          "for display (default: the file name in the scene, in the current folder; none for a "
          "--sample-range with a --checkpoint)")
      ->type_name("FILE")
      ->expected(1)
      ->take_all();
  o.render.addTo(*command);
  command
      ->add_option("--paths", o.paths,
                   "Only light paths of this class, such as 'LS+DE'; see 'recurse classes'")
      ->type_name("EXPR");
  o.develop.addTo(*command);
  addCheckpointOptions(*command, o);
  o.viewers.addTo(*command);
  addLayerOptions(*command, o);
  addRepetitionOptions(*command, o);
  command->add_flag("--send-scene", o.sendScene,
                    "For recurse-mpi: rank 0 alone reads the scene, and sends its files to the others");
  command->add_flag("--check", o.check, "Load the scene, report what it contains and needs, do not render");
  command->footer(EXAMPLES);
  command->callback([options, &chosen] {
    chosen = [options] {
      if (!options->frames.empty()) return renderFrames(*options);
      return options->watch ? renderAgainAndAgain(*options) : renderScene(*options);
    };
  });
}

} // namespace recurse::apps
