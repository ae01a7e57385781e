/** @file
 * `recurse render`: a scene file in, pictures out.
 */
#include <filesystem>
#include <optional>
#include <set>

#include "apps/commands.h"
#include "apps/integratorOptions.h"
#include "apps/interrupt.h"
#include "apps/optionText.h"
#include "apps/progressDisplay.h"
#include "apps/renderOutput.h"
#include "recurse/core/atomicFile.h"
#include "recurse/core/parallel.h"

namespace recurse::apps {

namespace {

struct RenderOptions {
  std::string scene;
  std::vector<std::string> outputs;
  IntegratorOptions integrator;
  std::optional<std::string> samples, timeLimit, threads, seed, resolution, cropWindow, exposure;
  std::string paths, statistics, progress = "auto";
  bool quiet = false, verbose = false, check = false, lenient = false;
};

/** The options once they have been understood. */
struct Plan {
  SceneOverrides overrides;
  std::optional<int> samples;
  std::optional<uint64_t> seed;
  double timeLimit = 0;
  int threads = 0;
  ImageWriteOptions write;
  PathClasses classes;
};

Plan planOf(const RenderOptions& o) {
  Plan plan;
  if (o.samples) plan.samples = static_cast<int>(parseCount("--spp", *o.samples, 1, 1 << 30));
  if (o.timeLimit) plan.timeLimit = parseDuration("--time-limit", *o.timeLimit);
  if (o.threads) plan.threads = static_cast<int>(parseCount("--nthreads", *o.threads, 1, 4096));
  if (o.seed) plan.seed = parseSeed("--seed", *o.seed);
  if (o.exposure) plan.write.exposure = static_cast<float>(parseReal("--exposure", *o.exposure));
  if (o.resolution) {
    const std::array<int, 2> size = parseResolution("--resolution", *o.resolution);
    plan.overrides.width = size[0];
    plan.overrides.height = size[1];
  }
  if (o.cropWindow) plan.overrides.cropWindow = parseCropWindow("--cropwindow", *o.cropWindow);
  plan.overrides.lenient = o.lenient;
  if (!o.paths.empty()) plan.classes = PathClasses(std::vector<PathClass>{{o.paths, o.paths}});
  return plan;
}

void checkOutputs(const RenderOptions& o, const std::vector<std::string>& outputs) {
  std::set<std::string> names;
  for (const std::string& name : outputs) {
    checkImageWritable(name);
    if (!names.insert(name).second) throw Error("-o: " + name + " is given twice", ExitStatus::BAD_USAGE);
  }
  if (!o.statistics.empty()) checkFileWritable(o.statistics);
}

/** The film's file name, in the current folder as pbrt has it; a picture with everything where it says
 * nothing. */
std::string defaultOutput(const LoadedScene& loaded) {
  std::filesystem::path name = loaded.scene->film().fileName;
  if (name.empty()) name = std::filesystem::path(loaded.fileName).stem();
  if (name.extension().empty()) name += ".exr";
  return name.string();
}

/** A command line that gives the same picture, whatever the scene file and the defaults become. */
std::string commandLine(const RenderOptions& o, const LoadedScene& loaded, const RenderSettings& settings) {
  std::string out = "recurse render " + shellQuoted(o.scene) + " --integrator " +
                    shellQuoted(loaded.integratorDirective.type) + o.integrator.text();
  if (settings.samplesPerPixel > 0) out += " --spp " + std::to_string(settings.samplesPerPixel);
  if (o.timeLimit) out += " --time-limit " + shellQuoted(*o.timeLimit);
  out += " --seed " + std::to_string(settings.seed);
  if (o.resolution) out += " --resolution " + *o.resolution;
  if (o.cropWindow) out += " --cropwindow " + *o.cropWindow;
  if (!o.paths.empty()) out += " --paths " + shellQuoted(o.paths);
  if (o.lenient) out += " --lenient";
  return out;
}

RenderStatistics renderShown(const LoadedScene& loaded, const Plan& plan, const RenderSettings& settings,
                             const RenderOptions& o, Film& film, const std::atomic<bool>& stop) {
  ProgressDisplay display(o.quiet ? ProgressMode::OFF : progressModeOf(o.progress));
  // Warnings are about what the picture will look like, so they come at once and even when quiet.
  const auto log = [&](const std::string& text) {
    if (o.verbose || text.starts_with("warning")) display.message(text);
  };
  return render(
      *loaded.scene, *loaded.integrator, plan.classes, settings, film, stop,
      [&](const RenderProgress& progress) { display.update(progress); }, log);
}

ExitStatus renderScene(const RenderOptions& o) {
  const Plan plan = planOf(o);
  checkOutputs(o, o.outputs);
  const ThreadPool pool(plan.threads);
  const LoadedScene loaded = loadAndBuild(o.scene, plan.overrides, o.integrator);
  if (o.check) {
    print(sceneReport(loaded, plan.classes.layerCount()));
    return ExitStatus::DONE;
  }
  const std::vector<std::string> outputs = o.outputs.empty() ? std::vector{defaultOutput(loaded)} : o.outputs;
  checkOutputs(o, outputs);
  if (o.verbose) std::fputs(sceneReport(loaded, plan.classes.layerCount()).c_str(), stderr);

  const Scene& scene = *loaded.scene;
  RenderSettings settings;
  settings.timeLimit = plan.timeLimit;
  settings.seed = plan.seed.value_or(scene.sampler().seed);
  // A time limit alone means: as many samples as fit.
  settings.samplesPerPixel = plan.samples.value_or(plan.timeLimit > 0 ? 0 : scene.sampler().pixelSamples);

  Film film(scene.film().crop, plan.classes.layerCount());
  const GracefulStop graceful;
  const RenderStatistics statistics = renderShown(loaded, plan, settings, o, film, graceful.flag());
  const bool interrupted = statistics.stopReason == StopReason::INTERRUPTED;
  if (interrupted && statistics.samples == 0)
    throw Error("interrupted before the first sample: nothing is written", ExitStatus::INTERRUPTED);

  const RenderReport report{loaded,
                            statistics,
                            settings.seed,
                            plan.classes.classes(),
                            commandLine(o, loaded, settings),
                            film.bounds().width(),
                            film.bounds().height()};
  const Image image = pictureOf(film, report);
  std::vector<std::string> written = outputs;
  // One output that fails must not take the others along.
  std::string failures;
  const auto attempt = [&failures](const std::function<void()>& write) {
    try {
      write();
      return true;
    } catch (const Error& error) {
      failures += (failures.empty() ? "" : "\nrecurse: ") + std::string(error.what());
      return false;
    }
  };
  std::erase_if(written, [&](const std::string& name) {
    return !attempt([&] { writeImage(name, image, plan.write); });
  });
  if (!o.statistics.empty() && attempt([&] { writeFileAtomically(o.statistics, statisticsJson(report)); }))
    written.push_back(o.statistics);
  if (!o.quiet) std::fputs(renderSummary(report, written, !o.verbose).c_str(), stderr);
  if (!failures.empty()) throw Error(failures);
  return interrupted ? ExitStatus::INTERRUPTED : ExitStatus::DONE;
}

} // namespace

void addRenderCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<RenderOptions>();
  RenderOptions& o = *options;
  CLI::App* command = app.add_subcommand("render", "Render a scene file to pictures");
  command->add_option("scene", o.scene, "Scene file, pbrt-v4 text format, may be gzip-compressed")
      ->required()
      ->type_name("SCENE");
  command
      ->add_option(
          "-o,--output", o.outputs,
          "Picture to write, several allowed: .exr with everything, .hdr and .pfm linear, .png .jpg .tif "
          "for display (default: the file name in the scene, in the current folder)")
      ->type_name("FILE")
      ->expected(1)
      ->take_all();
  o.integrator.addTo(*command);
  const auto text = [&](const char* name, auto& target, const char* type, const char* description) {
    command->add_option(name, target, description)->type_name(type);
  };
  text("--spp", o.samples, "N",
       "Samples per pixel (default: the scene's, or with --time-limit as many as fit)");
  text("--time-limit", o.timeLimit, "TIME",
       "Longest time for photons and picture: 30s, 2m, 1h30m; each pixel gets at least one sample");
  text("--nthreads", o.threads, "N",
       "Threads (default: one for each core); the picture does not depend on it");
  text("--seed", o.seed, "N", "Another seed, another independent picture (default: the scene's)");
  text("--resolution", o.resolution, "WxH", "Size of the picture in pixels (default: the scene's)");
  text("--cropwindow", o.cropWindow, "x0,x1,y0,y1",
       "Render this part only, as fractions of width and height");
  text("--paths", o.paths, "EXPR", "Only light paths of this class, such as 'LS+DE'; see 'recurse classes'");
  text("--exposure", o.exposure, "STOPS", "Brightness of .png .jpg .tif in powers of two (default: 0)");
  text("--stats", o.statistics, "FILE", "Write statistics as JSON");
  text("--progress", o.progress, "WAY", "auto, plain, json or off, on standard error (default: auto)");
  command->get_option("--progress")->check(CLI::IsMember({"auto", "plain", "json", "off"}))->type_name("WAY");
  CLI::Option* quiet = command->add_flag("-q,--quiet", o.quiet, "Print errors and warnings only");
  command->add_flag("-v,--verbose", o.verbose, "Print what the scene contains and what was chosen")
      ->excludes(quiet);
  command->add_flag("--check", o.check, "Load the scene, report what it contains and needs, do not render");
  command->add_flag("--lenient", o.lenient, "Unknown parameters in the scene are warnings instead of errors");
  command->footer(
      "Examples:\n"
      "  recurse render scene.pbrt -o picture.exr -o picture.png\n"
      "  recurse render scene.pbrt -o quick.png --time-limit 30s --resolution 320x240\n"
      "  recurse render scene.pbrt -o truth.exr --integrator path --spp 1024\n"
      "  recurse render scene.pbrt -o fine.exr --photons 10M --spp 64 --stats fine.json\n"
      "  recurse render scene.pbrt -o caustics.exr --paths 'LS+DE'\n"
      "  recurse render scene.pbrt --check\n\n"
      "Ctrl-C writes what there is; twice gives up at once. A file that exists is replaced only by a\n"
      "complete one.");
  command->callback([options, &chosen] { chosen = [options] { return renderScene(*options); }; });
}

} // namespace recurse::apps
