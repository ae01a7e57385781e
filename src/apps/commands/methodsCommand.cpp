/** @file
 * `recurse methods`: a scene rendered by every method, with the light that each of them omits.
 */
#include <filesystem>
#include <optional>

#include "apps/commands/commands.h"
#include "apps/load/missedLight.h"
#include "apps/options/namedRun.h"
#include "apps/options/optionText.h"
#include "apps/run/interrupt.h"
#include "apps/run/outputFiles.h"
#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/fileLock.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/pathclasses/pathExpression.h"
#include "recurse/report/methods/methods.h"

namespace recurse::apps {

namespace {

namespace fs = std::filesystem;

struct MethodsOptions {
  RenderOptions render;
  std::string folder;
  std::vector<std::string> methods;
  std::optional<std::string> referenceSamples, referenceMethod;
};

struct NamedMethod {
  const char *name, *options;
};
/** Methods, from local to global illumination. */
constexpr NamedMethod METHODS[] = {
    {"raycast", "--integrator raycast"},
    {"whitted", "--integrator whitted"},
    {"ambientocclusion", "--integrator ambientocclusion"},
    {"radiosity", "--integrator radiosity"},
    {"vpl", "--integrator vpl"},
    {"lightpath", "--integrator lightpath"},
    {"photonmap", "--integrator photonmap --set passes=1"},
    {"finalgather", "--integrator photonmap --set passes=1 --set finalgather=16"},
    {"progressive", "--integrator sppm"},
    {"path", "--integrator path"},
    {"bdpt", "--integrator bdpt"},
    {"vcm", "--integrator vcm"},
};
const char* const DEFAULT_TIME = "5s";

std::vector<Run> methodRuns(const MethodsOptions& o) {
  std::vector<Run> runs;
  const auto add = [&](const std::string& text) {
    runs.push_back(parseRun("--method", text, o.render, {"--time-limit", "--spp"}));
  };
  for (const std::string& text : o.methods) {
    const auto* known = std::find_if(std::begin(METHODS), std::end(METHODS),
                                     [&](const NamedMethod& m) { return m.name == text; });
    if (text.find('=') != std::string::npos)
      add(text);
    else
      add(text + "=" + (known != std::end(METHODS) ? known->options : "--integrator " + text));
  }
  if (o.methods.empty())
    for (const NamedMethod& m : METHODS) add(std::string(m.name) + "=" + m.options);
  for (size_t i = 0; i < runs.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (runs[i].name == runs[j].name)
        badUsage("--method " + runs[i].name + " is given twice; use different names");
  return runs;
}

void useIntegrator(LoadedScene& loaded, const ParsedDirective& directive, bool lenient) {
  Diagnostics diagnostics;
  loaded.integratorDirective = directive;
  loaded.integrator = makeIntegrator(directive, lenient, diagnostics);
  diagnostics.throwIfErrors();
}

std::string settingsText(const ParsedDirective& directive) {
  std::string out = directive.type;
  for (const std::string& setting : settingsOf(directive)) out += ", " + setting;
  return out;
}

/** Finished pictures with layers, as files of the folder. */
class Pictures {
 public:
  Pictures(LoadedScene& loaded, const StillsPlan& plan, std::string folder, const std::string& common)
      : loaded(loaded), plan(plan), classes(plan.classes), folder(std::move(folder)), common(common) {}

  std::string fileName(const std::string& name) const {
    return (fs::path(folder) / (name + ".exr")).string();
  }
  bool exists(const std::string& name) const { return fs::exists(fileName(name)); }

  /** Reads or renders a picture; nullopt when interrupted. `checkpoint`: a begun render is resumed. */
  std::optional<Stills> get(const std::string& name, const RenderOptions& options, const Retell& retell,
                            bool checkpoint = false) {
    const std::string identity = common + "; " + settingsText(loaded.integratorDirective) + "; " +
                                 (options.samples ? *options.samples + " samples" : *options.timeLimit) +
                                 "; seed " + options.seed.value_or("0");
    if (exists(name)) return read(name, identity);
    RenderPlan renderPlan = options.plan();
    if (renderPlan.timeLimit > 0)
      renderPlan.firstSampleTime = std::min(renderPlan.timeLimit, RenderSettings().firstSampleTime);
    renderPlan.limitsFirstPass = renderPlan.timeLimit > 0;
    const std::string kept = fileName(name) + ".checkpoint";
    if (checkpoint) {
      renderPlan.checkpoint = kept;
      renderPlan.resume = true;
    }
    try {
      const RenderResult result = renderLoaded(loaded, classes, renderPlan, options, retell);
      if (result.isInterrupted()) return {};
      const RenderReport report = result.report("recurse render");
      Stills stills = makeStills(result.film, plan, loaded.scene->film().imagingRatio);
      stills.image.metadata = metadataOf(report);
      stills.image.metadata["recurse:method"] = identity;
      stills.image.metadata["recurse:seconds"] = formatted("%.6g", result.statistics.renderSeconds);
      stills.image.metadata["recurse:samples"] = formatted("%.6g", report.samplesPerPixel());
      describeStills(stills);
      writeImage(fileName(name), stills.image);
    } catch (const Error& error) {
      if (error.status() == ExitStatus::INTERRUPTED) return {};
      throw;
    }
    std::error_code ignored;
    fs::remove(kept, ignored);
    return read(name, identity);
  }

 private:
  Stills read(const std::string& name, const std::string& identity) const {
    Stills stills = readStills(fileName(name));
    const auto found = stills.image.metadata.find("recurse:method");
    const std::string there = found == stills.image.metadata.end() ? "" : found->second;
    if (there != identity || stills.layers.size() != plan.shown + 1)
      throw Error(fileName(name) + " is a picture with other settings (" + there + "; now " + identity +
                      "). Choose another folder or another name, or remove this file",
                  ExitStatus::BAD_USAGE);
    return stills;
  }

  LoadedScene& loaded;
  const StillsPlan& plan;
  PathClasses classes;
  std::string folder, common;
};

double figure(const Stills& stills, const char* name) {
  return parseReal(name, stills.image.metadata.at(std::string("recurse:") + name));
}

/** Refines the default classes by the claims; keeps the default if the result has too many layers. */
void chooseClasses(MethodsReport& report, const std::vector<std::string>& claims, bool withMedia) {
  try {
    report.classes = refineClasses(defaultStillClasses(withMedia), claims);
    const PathClasses rendered(planStills(report.classes).classes);
  } catch (const Error&) {
    report.classes = defaultStillClasses(withMedia);
    report.isExact = false;
  }
}

/** Sets a default "maxdistance" of ambient occlusion to half of the scene's radius: at infinite distance, the
 * surfaces of a closed room occlude the whole sky. */
void setAmbientReach(ParsedDirective& integrator, const SceneBounds& bounds) {
  const auto isReach = [](const ParsedParameter& p) { return p.name == "maxdistance"; };
  if (integrator.type != "ambientocclusion" ||
      std::any_of(integrator.parameters.begin(), integrator.parameters.end(), isReach))
    return;
  const std::string reach = formatted("\"float maxdistance\" %.3g", double(bounds.radius) / 2);
  integrator.parameters.push_back(parseParameterText(integrator.type, reach).parameters.front());
}

/** Adds a method to the report for each run, and chooses classes that distinguish the claims. */
void startReport(MethodsReport& report, std::vector<Run>& runs, LoadedScene& loaded, bool lenient) {
  std::vector<std::string> claims;
  for (Run& run : runs) {
    try {
      run.integrator = run.options.integrator.directive(loaded.description.integrator);
      setAmbientReach(run.integrator, loaded.scene->bounds());
      useIntegrator(loaded, run.integrator, lenient);
    } catch (const Error& error) {
      throw Error("--method " + run.name + ": " + error.what(), error.status());
    }
    MethodResult& method = report.methods.emplace_back();
    method.name = run.name;
    method.settings = settingsText(run.integrator);
    method.claims = loaded.integrator->claims().empty() ? "all" : loaded.integrator->claims();
    method.suppositions = loaded.integrator->suppositions();
    if (!loaded.integrator->claims().empty()) claims.push_back(method.claims);
  }
  chooseClasses(report, claims, loaded.scene->hasMedia());
}

/** Options of the references' renders. */
RenderOptions referenceOptions(const MethodsOptions& o) {
  RenderOptions options = o.render;
  options.timeLimit.reset();
  options.adaptive = options.verbose = false;
  options.samples = std::to_string(
      o.referenceSamples ? parseCount("--reference-spp", *o.referenceSamples, 1, 1 << 30) : 256);
  return options;
}

/** Sets the integrator of the references in options and scene, and returns its name. */
std::string chooseReferenceMethod(const MethodsOptions& o, RenderOptions& reference, LoadedScene& loaded,
                                  const std::vector<PathClass>& classes) {
  const auto choose = [&](const std::string& name) {
    reference.integrator.setIntegrator(name);
    useIntegrator(loaded, reference.integrator.directive(loaded.description.integrator), o.render.lenient);
    return name;
  };
  const std::string method = choose(o.referenceMethod.value_or("path"));
  return o.referenceMethod || missedPaths(loaded, classes).empty() ? method : choose("sppm");
}

/** Renders two independent references into the report, with the integrator that the scene has. False when it
 * was interrupted. */
bool renderReferences(MethodsReport& report, RenderOptions options, uint64_t seed, Pictures& pictures,
                      const GracefulStop& graceful) {
  for (const bool second : {false, true}) {
    // Seeds far from the ones that users choose.
    options.seed = std::to_string((seed + (second ? 2 : 1)) * 0x9e3779b97f4a7c15ull);
    const std::string name = second ? "reference-b" : "reference-a";
    std::optional<Stills> stills = pictures.get(
        name, options, [&](RenderProgress& p) { p.phase = name; }, true);
    if (!stills || graceful.flag()) return false;
    (second ? report.referenceB : report.referenceA) = std::move(*stills);
  }
  prepareReferences(report);
  return true;
}

/** Sets the picture of a method, its time and its samples. Throws Error below one sample per pixel. */
void setPicture(MethodResult& method, Stills stills) {
  method.stills = std::move(stills);
  method.seconds = figure(method.stills, "seconds");
  method.samplesPerPixel = figure(method.stills, "samples");
  if (method.samplesPerPixel < 1)
    throw Error(
        formatted("the time limit ended after %.2g samples per pixel; give it more time (--time-limit)",
                  method.samplesPerPixel));
}

/** Renders and measures each run as the method with the same index in the report. After an interruption, for
 * which it returns false, it only uses pictures that exist. */
bool renderMethods(MethodsReport& report, const std::vector<Run>& runs, const RenderOptions& common,
                   LoadedScene& loaded, Pictures& pictures, const GracefulStop& graceful) {
  bool stopped = false;
  for (size_t i = 0; i < runs.size(); ++i) {
    const Run& run = runs[i];
    MethodResult& method = report.methods[i];
    const std::string name = "method-" + run.name;
    useIntegrator(loaded, run.integrator, common.lenient);
    const std::string phase = run.name + ", " + std::to_string(i + 1) + " of " + std::to_string(runs.size());
    try {
      std::optional<Stills> stills;
      if (!stopped || pictures.exists(name))
        stills = pictures.get(name, run.options, [&](RenderProgress& p) { p.phase = phase; });
      stopped = stopped || !stills || graceful.flag();
      if (!stills) throw Error("not rendered: interrupted");
      setPicture(method, std::move(*stills));
    } catch (const Error& error) {
      if (error.status() == ExitStatus::BAD_USAGE) throw;
      method.failure = error.what();
    }
    measureMethod(method, report);
    if (!common.quiet && method.failure.empty()) say(phase + ": done\n");
  }
  return !stopped;
}

void writeReport(const MethodsReport& report, const std::string& folder) {
  const auto file = [&](const char* name) { return (fs::path(folder) / name).string(); };
  writeImage(file("sheet.png"), methodsSheet(report));
  writeFileAtomically(file("methods.json"), methodsJson(report));
  writeFileAtomically(file("index.html"), methodsPage(report));
  print(methodsTable(report));
}

void makeMethodsFolder(const std::string& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) throw Error(folder + ": " + failure.message());
  checkFileWritable((fs::path(folder) / "index.html").string());
}

ExitStatus compareMethods(const MethodsOptions& options) {
  MethodsOptions o = options;
  if (!o.render.samples && !o.render.timeLimit) o.render.timeLimit = DEFAULT_TIME;
  if (o.render.samples && o.render.timeLimit) badUsage("use only one of --spp and --time-limit");
  const RenderPlan plan = o.render.plan();
  std::vector<Run> runs = methodRuns(o);
  RenderOptions reference = referenceOptions(o);
  const ThreadPool pool(plan.threads);
  LoadedScene loaded = loadAndBuild(o.render.scene, plan.overrides, IntegratorOptions());
  const PixelBounds& crop = loaded.scene->film().crop;
  std::vector<OutputFile> outputs;
  for (const std::string name :
       {"index.html", "sheet.png", "methods.json", "reference-a.exr", "reference-b.exr"})
    outputs.push_back({"-o", (fs::path(o.folder) / name).string()});
  for (const Run& run : runs)
    outputs.push_back({"-o", (fs::path(o.folder) / ("method-" + run.name + ".exr")).string()});
  requireDistinctFiles(outputs, inputFiles("a file of the scene", loaded.files));
  makeMethodsFolder(o.folder);
  const FileLock lock(folderName(o.folder));

  MethodsReport report;
  startReport(report, runs, loaded, o.render.lenient);
  const StillsPlan stillsPlan = planStills(report.classes);
  const std::string size = std::to_string(crop.width()) + "x" + std::to_string(crop.height());
  report.title = fs::path(o.render.scene).filename().string();
  report.label = size + " pixels, " +
                 (o.render.samples ? *o.render.samples + " samples per pixel" : *o.render.timeLimit) +
                 " each, " + std::to_string(threadCount()) + (threadCount() == 1 ? " thread" : " threads");
  Pictures pictures(loaded, stillsPlan, o.folder,
                    contentHash(loaded.description) + "; " + size + " at " + std::to_string(crop.x0) + " " +
                        std::to_string(crop.y0) + "; Recurse " + VERSION + "; " +
                        classesText(stillsPlan.classes));

  const GracefulStop graceful;
  const std::string referenceMethod = chooseReferenceMethod(o, reference, loaded, stillsPlan.classes);
  bool isComplete =
      renderReferences(report, reference, plan.settings(*loaded.scene).seed, pictures, graceful);
  if (isComplete) {
    report.reference = "two by " + referenceMethod + ", " + *reference.samples + " samples per pixel each; " +
                       referenceError(report.references.a, report.references.b).text();
    isComplete = renderMethods(report, runs, o.render, loaded, pictures, graceful);
    writeReport(report, o.folder);
  }
  if (!isComplete) {
    say("interrupted; finished pictures are kept in " + o.folder + "; run the same command to continue\n");
    return ExitStatus::INTERRUPTED;
  }
  if (!o.render.quiet)
    say("written: " + (fs::path(o.folder) / "index.html").string() +
        ", sheet.png, methods.json, method-*.exr\n");
  return ExitStatus::DONE;
}

} // namespace

void addMethodsCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<MethodsOptions>();
  MethodsOptions& o = *options;
  CLI::App* command =
      app.add_subcommand("methods", "Render a scene by each method, and show what each method leaves out");
  o.render.addSceneTo(*command);
  command
      ->add_option("-o,--output", o.folder,
                   "Folder for index.html, sheet.png, methods.json and the pictures; it is created if "
                   "needed. An existing comparison is continued")
      ->required()
      ->type_name("DIR");
  std::string names;
  for (const NamedMethod& m : METHODS) names += (names.empty() ? "" : ", ") + std::string(m.name);
  addRepeatedOption(*command, "--method", o.methods,
                    "Method by name, may be repeated: " + names +
                        ", any other integrator; or NAME=\"OPTIONS\" with options of 'recurse render' "
                        "(default: all methods of this list)")
      ->type_name("NAME[=\"OPTIONS\"]");
  o.render.addTo(*command);
  for (const char* taken : {"--photons", "--stats"}) command->remove_option(command->get_option(taken));
  command
      ->add_option("--reference-spp", o.referenceSamples,
                   "Samples per pixel of each of the two references (default: 256)")
      ->type_name("N");
  command
      ->add_option("--reference-by", o.referenceMethod,
                   "Integrator of the references (default: path, or sppm if path cannot find all light)")
      ->type_name("NAME");
  command->footer(
      "All methods get the same --time-limit (default: 5s) or the same --spp. The first sample of each\n"
      "pixel may take up to twice the time limit; a method without it has no picture. References have no\n"
      "time limit. Pictures are rendered by path classes that separate the paths that a method computes\n"
      "from those that it leaves out, so that the errors of both are separate. The maximum distance of\n"
      "ambient occlusion is half of the scene's radius.\n\n"
      "Examples:\n"
      "  recurse methods scene.pbrt -o methods\n"
      "  recurse methods scene.pbrt -o whitted --method whitted --method path --spp 64\n"
      "  recurse methods scene.pbrt -o vpl --method few=\"--integrator vpl --set lightpaths=8\" --method "
      "vpl\n\n"
      "Ctrl-C keeps all finished pictures; run the same command to continue.");
  command->callback([options, &chosen] { chosen = [options] { return compareMethods(*options); }; });
}

} // namespace recurse::apps
