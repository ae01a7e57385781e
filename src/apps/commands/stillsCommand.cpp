/** @file
 * `recurse stills`: one render with a picture for each class of paths.
 */
#include <algorithm>
#include <filesystem>
#include <optional>

#include "apps/commands/commands.h"
#include "apps/load/modelScene.h"
#include "apps/options/optionText.h"
#include "apps/options/renderOptions.h"
#include "apps/run/outputFiles.h"
#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/fileLock.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/pathclasses/pathExpression.h"
#include "recurse/report/stills/stills.h"
#include "recurse/transport/integrator/sceneNames.h"

namespace recurse::apps {

namespace {

namespace fs = std::filesystem;

struct StillsOptions {
  RenderOptions render;
  std::string folder, compare, by;
  std::vector<std::string> classes;
};

/** The requested classes. Throws Error, before the scene is loaded, for those that are wrong in any scene. */
std::vector<PathClass> askedClasses(const StillsOptions& o) {
  std::vector<PathClass> classes;
  for (const std::string& text : o.classes) classes.push_back(parseClass("--class", text));
  if (!classes.empty()) planStills(classes);
  return classes;
}

/** Plan of the classes, divided by light where --by asks for this. */
StillsPlan planOf(const StillsOptions& o, std::vector<PathClass> classes, const LoadedScene& loaded) {
  const Scene& scene = *loaded.scene;
  if (classes.empty() && o.by != "light") return planStills(defaultStillClasses(scene.hasMedia()));
  const PathNames names = pathNames(scene, loaded.integrator.get());
  if (o.by != "light") return planStills(classes, &names);
  const std::vector<LampGroup> lamps = lampGroups(scene);
  if (!classes.empty()) classes = planStills(classes, &names).classes;
  StillsPlan plan = planStills(classesByLight(lamps, classes), &names);
  constexpr size_t MOST_REMARKS = 62; // as many as there are layers
  for (size_t i = 0; i < std::min(lamps.size(), MOST_REMARKS); ++i)
    plan.remarks.push_back(lamps[i].name + " is " + lamps[i].place);
  return plan;
}

/** Throws Error if statistics or inputs are among the files that the folder gets. */
void checkFiles(const StillsOptions& o, const std::vector<std::string>& sceneFiles) {
  std::vector<OutputFile> outputs = {{"--stats", o.render.statistics}};
  std::vector<InputFile> inputs = inputFiles("a file of the scene", sceneFiles);
  inputs.push_back({"the stills of --compare", stillsFile(o.compare)});
  for (const char* name : {"common", "own"})
    requireOutsideOf((fs::path(o.folder) / name).string(), outputs, inputs);
  for (const char* name : {"stills.exr", "sheet.png", "index.html"})
    outputs.push_back({"-o", (fs::path(o.folder) / name).string()});
  requireDistinctFiles(outputs, inputs);
}

/** Throws Error, before the render, for stills of a different size. */
void checkComparable(const Stills& other, const Scene& scene, const std::string& name) {
  const PixelBounds& crop = scene.film().crop;
  if (other.image.width != crop.width() || other.image.height != crop.height())
    throw Error("--compare: " + name + " has " + std::to_string(other.image.width) + "x" +
                    std::to_string(other.image.height) + " pixels, but this render has " +
                    std::to_string(crop.width()) + "x" + std::to_string(crop.height()),
                ExitStatus::BAD_USAGE);
}

ExitStatus renderStills(const StillsOptions& o) {
  const RenderPlan plan = o.render.plan();
  const std::vector<PathClass> asked = askedClasses(o);
  if (!o.render.statistics.empty()) checkFileWritable(o.render.statistics);
  std::optional<Stills> other;
  if (!o.compare.empty()) other = readStills(o.compare);
  const ThreadPool pool(plan.threads);
  std::optional<NothingToWrite> loading(plan.timeLimit);
  const LoadedScene loaded = loadAndBuild(o.render.scene, plan.overrides, o.render.integrator);
  loading.reset();
  if (other) checkComparable(*other, *loaded.scene, o.compare);
  checkFiles(o, loaded.files);
  checkStillsWritable(o.folder);
  const FileLock lock(folderName(o.folder));
  const StillsPlan stillsPlan = planOf(o, asked, loaded);
  const PathClasses classes = sceneClasses(stillsPlan.classes, *loaded.scene, loaded.integrator.get());

  std::string classOptions = o.by.empty() ? "" : " --by " + o.by;
  for (const std::string& text : o.classes) classOptions += " --class " + shellQuoted(text);
  const RenderResult result = renderLoaded(loaded, classes, plan, o.render);
  const RenderReport report = result.report("recurse stills", classOptions);
  Stills stills = makeStills(result.film, stillsPlan, loaded.scene->film().imagingRatio);
  stills.image.metadata = metadataOf(report);
  stills.title = o.render.scene.substr(o.render.scene.find_last_of('/') + 1);
  if (!isModelFile(o.render.scene)) stills.scene = stills.title;
  if (o.by == "light" && asked.empty()) noteLamps(stills, lampGroups(*loaded.scene));
  stills.label = loaded.integratorDirective.type + ", " + formatted("%.4g", report.samplesPerPixel()) +
                 " samples per pixel";
  if (result.isInterrupted()) stills.label += ", interrupted";
  describeStills(stills);
  writeStills(o.folder, stills, other ? &*other : nullptr);
  std::vector<std::string> written;
  for (const char* name : {"stills.exr", "sheet.png", "index.html", "common/*.png", "own/*.png"})
    written.push_back(folderName(o.folder) + name);
  if (!o.render.statistics.empty()) {
    writeFileAtomically(o.render.statistics, statisticsJson(report));
    written.push_back(o.render.statistics);
  }
  if (!o.render.quiet) {
    say(renderSummary(report, written, !o.render.verbose));
    print(stillsTable(stills));
  }
  return result.isInterrupted() ? ExitStatus::INTERRUPTED : ExitStatus::DONE;
}

} // namespace

void addStillsCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<StillsOptions>();
  StillsOptions& o = *options;
  CLI::App* command =
      app.add_subcommand("stills", "Render each class of light paths to a picture of its own");
  o.render.addSceneTo(*command);
  command
      ->add_option("-o,--output", o.folder,
                   "Folder for stills.exr, sheet.png, index.html, common/ and own/; it is created if needed")
      ->required()
      ->type_name("DIR");
  addRepeatedOption(
      *command, "--class", o.classes,
      "A class of paths, such as caustic=LS+DE; may be repeated; see 'recurse classes' (default: ten "
      "classes that add up to the whole picture, and six more for scenes with media)")
      ->type_name("NAME=EXPR");
  command
      ->add_option("--by", o.by,
                   "A layer for the light of each lamp, by its name in the scene file or its number; with "
                   "--class, one for each class and lamp")
      ->type_name("light")
      ->check(CLI::IsMember({"light"}));
  command
      ->add_option("--compare", o.compare,
                   "Other stills of the same size, a folder or an EXR file, to compare on the page")
      ->type_name("DIR|EXR");
  o.render.addTo(*command);
  command->footer(
      "stills.exr has the whole picture in R, G, B and each class in NAME.R, NAME.G, NAME.B. common/ has\n"
      "each class as PNG at the exposure of the whole picture, own/ at its own exposure: the\n"
      "98th percentile of the luminance of non-black pixels becomes 0.9 of white. sheet.png shows all\n"
      "classes with their names, and index.html is a page for a browser. Paths outside of the given classes\n"
      "become the class 'rest'.\n\n"
      "Examples:\n"
      "  recurse stills scene.pbrt -o stills\n"
      "  recurse stills scene.pbrt -o stills --class caustic=LS+DE --class mirrored=LDS+E --spp 64\n"
      "  recurse stills scene.pbrt -o lamps --by light\n"
      "  recurse stills scene.pbrt -o floor --class \"floor=L'lamp'S*D'floor'E\"\n"
      "  recurse stills scene.pbrt -o path --integrator path --compare stills");
  command->callback([options, &chosen] { chosen = [options] { return renderStills(*options); }; });
}

} // namespace recurse::apps
