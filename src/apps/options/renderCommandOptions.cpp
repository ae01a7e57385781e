/** @file
 * Options of `recurse render`, and their checks.
 */
#include "apps/options/renderCommandOptions.h"

#include <algorithm>
#include <filesystem>

#include "apps/options/optionText.h"
#include "apps/run/console.h"
#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/text.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/transport/integrator/sceneNames.h"

namespace recurse::apps {

namespace {

constexpr const char* EXAMPLES =
    "Examples:\n"
    "  recurse render scene.pbrt -o picture.exr -o picture.png\n"
    "  recurse render scene.pbrt -o quick.png --time-limit 30s --resolution 320x240\n"
    "  recurse render scene.pbrt -o truth.exr --integrator path --spp 1024\n"
    "  recurse render scene.pbrt -o sure.exr --integrator path --error-target 0.05\n"
    "  recurse render scene.pbrt -o even.exr --integrator path --spp 256 --adaptive --samples-layer\n"
    "  recurse render scene.pbrt -o fine.exr --photons 10M --spp 64 --stats fine.json\n"
    "  recurse render scene.pbrt -o caustics.exr --paths 'LS+DE'\n"
    "  recurse render scene.pbrt -o classes.exr --class 'caustic=LS+DE' --class 'direct=LDE'\n"
    "  recurse render scene.pbrt -o bright.png --exposure auto+1 --tonemap reinhard\n"
    "  recurse render scene.pbrt -o plain.png --exposure 0 --tonemap none\n"
    "  recurse render scene.pbrt -o long.exr --spp 4096 --checkpoint long.rck --resume\n"
    "  recurse render scene.pbrt -o half.exr --spp 512 --sample-range 0:256 --checkpoint a.rck\n"
    "  recurse render scene.pbrt -o layers.exr --layers albedo,normal,depth\n"
    "  recurse render scene.pbrt -o long.exr --spp 4096 --live\n"
    "  recurse render pak0.pk3 --map q3dm1 --camera spawn:1 -o map.png\n"
    "  recurse render scene.pbrt -o long.exr --spp 4096 --preview look.png --every 30s\n"
    "  recurse render scene.pbrt -o look.png --watch --time-limit 20s\n"
    "  recurse render scenes/animation.pbrt --frames 0:48 -o film.png\n"
    "  recurse render scene.pbrt --time-of-flight 0:12:60 -o film.png -o film.exr\n"
    "  recurse render scene.pbrt --check\n\n"
    "Ctrl-C writes the picture of the samples so far; a second Ctrl-C quits without it. Existing files are\n"
    "replaced by complete files only.";

void addCheckpointOptions(CLI::App& command, RenderCommandOptions& o) {
  command
      .add_option("--checkpoint", o.checkpoint,
                  "File that keeps the state of the render; it is written at intervals, at the end and at an "
                  "interrupt")
      ->type_name("FILE");
  command
      .add_option("--checkpoint-interval", o.checkpointInterval,
                  "Interval between checkpoints (default: 60s)")
      ->type_name("TIME");
  command.add_flag("--resume", o.resume,
                   "Continue the render of the --checkpoint file with bit-identical results; start a new one "
                   "if there is no such file");
  command
      .add_option("--sample-range", o.sampleRange,
                  "Render only the samples FIRST to END-1 of the --spp of each pixel; 'recurse merge' adds "
                  "such renders")
      ->type_name("FIRST:END");
}

void addLayerOptions(CLI::App& command, RenderCommandOptions& o) {
  command.add_flag("--error-layer", o.extra.error,
                   "Add the standard error of each pixel's luminance to .exr, as channel error.Y");
  command.add_flag("--samples-layer", o.extra.samples,
                   "Add the number of samples of each pixel to .exr, as channel samples.N");
  command
      .add_option("--layers", o.layers,
                  "Add features of the visible surfaces to .exr: albedo, normal (shading normal, towards the "
                  "camera), geonormal (geometric normal), depth (distance), position (in world space), "
                  "cryptoobject and cryptomaterial (Cryptomatte), guide (of path guiding: the fraction of "
                  "samples that "
                  "are guided at the first non-delta surface)")
      ->type_name("NAME,NAME...");
  command.add_flag("--layers-through", o.throughSpecular,
                   "For --layers: show the features of surfaces in mirrors and behind smooth glass");
}

void addRepetitionOptions(CLI::App& command, RenderCommandOptions& o) {
  command.add_flag("--watch", o.watch,
                   "Render again when a file of the scene changes, first at a quarter of width and height, "
                   "until Ctrl-C; with --frames all frames");
  command
      .add_option("--frames", o.frames,
                  "Render the frames FIRST to LAST, or one frame, of a scene with Animate directives: '-o "
                  "film.png' writes film-0000.png and so on, '-o film##.png' film00.png. The first frame "
                  "that is not black sets the exposure of .png for all frames; set --exposure if several "
                  "calls render parts of an animation. Unchanged files, shapes and objects are reused "
                  "between frames. A --time-limit is for each frame. '-o film.apng' (animated PNG) and '-o "
                  "film.mp4' (by ffmpeg) hold all frames")
      ->type_name("FIRST:LAST");
  command
      .add_option("--time-of-flight", o.timeOfFlight,
                  "Render light in flight: a film of FRAMES frames, each with the light whose path from the "
                  "lamp to the camera has an optical length [scene units] in its part of FROM to TO. '-o "
                  "film.png' and .apng are animated PNGs, .mp4 a video (by ffmpeg), all with one exposure; "
                  ".exr has a layer for each frame, and for light before and after them. For the integrators "
                  "auto, path, photonmap, bdpt, vcm and the simple ones")
      ->type_name("FROM:TO:FRAMES");
  command.add_option("--frame-rate", o.frameRate, "Frames per second of .apng and .mp4 (default: 24)")
      ->type_name("FPS");
}

} // namespace

void RenderCommandOptions::checkOutputs(const std::vector<std::string>& outputs) const {
  for (const std::string& name : outputs) {
    if (isAnimationFormat(name) && frames.empty() && timeOfFlight.empty())
      badUsage(name + ": is a film; it needs --frames or --time-of-flight");
    isAnimation(name) ? checkAnimationOutput(name, develop) : checkImageWritable(name);
  }
  viewers.check();
  requireDistinctFiles(written(outputs), {});
  if (!render.statistics.empty()) checkFileWritable(render.statistics);
  if (checkpoint.empty()) return;
  if (!resume && std::filesystem::exists(checkpoint))
    throw Error("--checkpoint: " + checkpoint + " exists; continue it with --resume, or remove it",
                ExitStatus::BAD_USAGE);
  checkFileWritable(checkpoint);
}

void RenderCommandOptions::keepInputs(const std::vector<std::string>& outputs,
                                      const std::vector<std::string>& inputs) const {
  requireDistinctFiles(written(outputs), inputFiles("a file of the scene", inputs));
}

std::vector<OutputFile> RenderCommandOptions::written(const std::vector<std::string>& outputs) const {
  std::vector<OutputFile> out = outputFiles("-o", outputs);
  out.insert(out.end(),
             {{"--preview", viewers.preview}, {"--stats", render.statistics}, {"--checkpoint", checkpoint}});
  return out;
}

bool RenderCommandOptions::isAnimation(const std::string& output) const {
  return timeOfFlight.empty() ? isAnimationFormat(output) : isTransientAnimation(output);
}

void RenderCommandOptions::checkIntegrator(const LoadedScene& loaded) const {
  if (timeOfFlight.empty() || loaded.integrator->supportsTransient(*loaded.scene)) return;
  const std::string& type = loaded.integratorDirective.type;
  if (loaded.scene->hasEmissiveMedia())
    badUsage("--time-of-flight: the scene has a medium that emits light, along whole rays and at no certain "
             "time");
  std::string able;
  for (const auto& entry : plugIns().integrators.entries()) {
    Diagnostics none;
    ParsedDirective directive;
    directive.type = entry.name;
    const auto made = makeIntegrator(directive, false, none);
    if (made && made->supportsTransient(*loaded.scene)) able += " " + entry.name;
  }
  const std::string message = "\"" + type +
                              "\" does not measure the lengths of paths, as --time-of-flight "
                              "needs them; these do:" +
                              able;
  if (render.integrator.named()) badUsage("--integrator: " + message);
  Diagnostics diagnostics;
  diagnostics.error(loaded.integratorDirective.location, message);
  diagnostics.throwIfErrors();
}

PathClasses RenderCommandOptions::pathClasses(const LoadedScene& loaded) const {
  PathClasses all = sceneClasses(pathClasses(), *loaded.scene, loaded.integrator.get());
  if (!timeOfFlight.empty()) all.addFrames(parseTimeOfFlight(timeOfFlight));
  return all;
}

std::vector<PathClass> RenderCommandOptions::pathClasses() const {
  if (!paths.empty() && !classes.empty()) badUsage("--class: cannot be combined with --paths");
  if (!timeOfFlight.empty()) {
    if (!classes.empty()) badUsage("--time-of-flight: cannot be combined with --class; --paths EXPR can");
    if (!frames.empty()) badUsage("--time-of-flight: cannot be combined with --frames");
    parseTimeOfFlight(timeOfFlight);
  }
  std::vector<PathClass> all = {{"all", "all"}};
  if (!paths.empty()) all = {{paths, paths}};
  for (const std::string& text : classes) all.push_back(parseClass("--class", text));
  PathClasses::check(all);
  return all;
}

std::string RenderCommandOptions::pathsText() const {
  std::string out = paths.empty() ? "" : " --paths " + shellQuoted(paths);
  for (const std::string& text : classes) out += " --class " + shellQuoted(text);
  if (!timeOfFlight.empty()) out += " --time-of-flight " + shellQuoted(timeOfFlight);
  return out;
}

RenderPlan RenderCommandOptions::plan() const {
  RenderPlan out = render.plan();
  out.checkpoint = checkpoint;
  out.resume = resume;
  const auto needsCheckpoint = [&](bool given, const char* option) {
    if (given && checkpoint.empty())
      throw Error(std::string(option) + ": needs --checkpoint FILE", ExitStatus::BAD_USAGE);
  };
  needsCheckpoint(resume, "--resume");
  needsCheckpoint(checkpointInterval.has_value(), "--checkpoint-interval");
  if (checkpointInterval)
    out.checkpointInterval = parseDuration("--checkpoint-interval", *checkpointInterval);
  if (!sampleRange) return out;
  if (out.adaptive)
    throw Error("--sample-range: cannot be combined with --adaptive, which chooses samples from earlier "
                "ones; render parts with different seeds (--seed) instead",
                ExitStatus::BAD_USAGE);
  const std::vector<std::string> range = split(*sampleRange, ':');
  if (range.size() != 2)
    throw Error("--sample-range: '" + *sampleRange + "' is not FIRST:END, such as 64:128",
                ExitStatus::BAD_USAGE);
  if (!out.samples)
    throw Error("--sample-range: needs --spp N, the total number of samples per pixel",
                ExitStatus::BAD_USAGE);
  out.firstSample = parseCount("--sample-range", range[0], 0, *out.samples - 1);
  out.endSample = parseCount("--sample-range", range[1], out.firstSample + 1, *out.samples);
  return out;
}

FeatureSettings RenderCommandOptions::features(const std::vector<std::string>& outputs, bool layered) const {
  FeatureSettings out;
  out.throughSpecular = throughSpecular;
  const bool hasExr = std::any_of(outputs.begin(), outputs.end(),
                                  [](const auto& name) { return lowerCase(name).ends_with(".exr"); });
  if (!layers.empty()) {
    out.layers = split(layers, ',');
    requireFeatureLayers(out.layers);
    if (!hasExr) badUsage("--layers: needs an .exr output; add -o FILE.exr");
    for (const PathClass& one : pathClasses())
      if (std::find(out.layers.begin(), out.layers.end(), one.name) != out.layers.end())
        badUsage("--class: " + one.name + " is a layer of --layers; give the class another name");
  } else if (layered && hasExr) { // layers that pbrt has, too
    for (const FeatureLayer& layer : featureLayers())
      if (*layer.channels && layer.isOfScene) out.layers.emplace_back(layer.name);
  } else if (throughSpecular) {
    badUsage("--layers-through: needs --layers");
  }
  if (!outputs.empty() && !hasExr && (!classes.empty() || extra.error || extra.samples))
    say("warning: only .exr outputs have the layers of --class, --error-layer and --samples-layer; add -o "
        "FILE.exr\n");
  return out;
}

RenderCommandOptions RenderCommandOptions::withoutOutputs() const {
  plan(); // throws Error for options that are wrong in all processes
  RenderCommandOptions o = *this;
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

void RenderCommandOptions::addTo(CLI::App& command) {
  render.addSceneTo(command);
  addRepeatedOption(
      command, "-o,--output", outputs,
      "Picture to write, may be repeated: .exr with all channels, .hdr and .pfm linear, .png .jpg .tif "
      "for display (default: the file name in the scene, in the current folder; none for a "
      "--sample-range with a --checkpoint)")
      ->type_name("FILE");
  render.addTo(command);
  command
      .add_option("--paths", paths,
                  "Render only light paths of this class, such as 'LS+DE'; see 'recurse classes'")
      ->type_name("EXPR");
  addRepeatedOption(
      command, "--class", classes,
      "Add the light paths of a class to .exr, such as caustic=LS+DE as caustic.R, caustic.G and "
      "caustic.B; may be repeated")
      ->type_name("NAME=EXPR");
  develop.addTo(command);
  addCheckpointOptions(command, *this);
  viewers.addTo(command);
  addLayerOptions(command, *this);
  addRepetitionOptions(command, *this);
  command.add_flag(
      "--send-scene", sendScene,
      "For recurse-mpi: rank 0 alone reads the scene files, and sends them to the other processes");
  command.add_flag("--check", check, "Load the scene, report its contents and memory, and do not render");
  command.footer(EXAMPLES);
}

} // namespace recurse::apps
