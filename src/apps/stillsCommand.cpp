/** @file
 * `recurse stills`: one render, every class of paths a picture of its own.
 */
#include <optional>

#include "apps/commands.h"
#include "apps/optionText.h"
#include "apps/renderOptions.h"
#include "recurse/core/atomicFile.h"
#include "recurse/core/parallel.h"
#include "recurse/report/stills.h"
#include "recurse/transport/pathExpression.h"

namespace recurse::apps {

namespace {

struct StillsOptions {
  RenderOptions render;
  std::string folder, compare;
  std::vector<std::string> classes;
};

/** The plan of the classes that are asked for. */
StillsPlan planOf(const StillsOptions& o) {
  std::vector<PathClass> classes;
  for (const std::string& text : o.classes) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
      throw Error("--class: '" + text + "' is not NAME=EXPRESSION, such as caustic=LS+DE",
                  ExitStatus::BAD_USAGE);
    classes.push_back({text.substr(0, equals), text.substr(equals + 1)});
  }
  return planStills(classes);
}

/** Fails before the render where it can, not after it. */
void checkComparable(const Stills& other, const Scene& scene, const std::string& name) {
  const PixelBounds& crop = scene.film().crop;
  if (other.image.width != crop.width() || other.image.height != crop.height())
    throw Error("--compare: " + name + " has " + std::to_string(other.image.width) + "x" +
                    std::to_string(other.image.height) + " pixels, this render has " +
                    std::to_string(crop.width()) + "x" + std::to_string(crop.height()),
                ExitStatus::BAD_USAGE);
}

ExitStatus renderStills(const StillsOptions& o) {
  const RenderPlan plan = o.render.plan();
  std::optional<StillsPlan> asked;
  if (!o.classes.empty()) asked = planOf(o);
  if (!o.render.statistics.empty()) checkFileWritable(o.render.statistics);
  std::optional<Stills> other;
  if (!o.compare.empty()) other = readStills(o.compare);
  const ThreadPool pool(plan.threads);
  const LoadedScene loaded = loadAndBuild(o.render.scene, plan.overrides, o.render.integrator);
  if (other) checkComparable(*other, *loaded.scene, o.compare);
  checkStillsWritable(o.folder);
  const StillsPlan stillsPlan = asked ? *asked : planStills(defaultStillClasses(loaded.scene->hasMedia()));
  const PathClasses classes(stillsPlan.classes);

  std::string classOptions;
  for (const std::string& text : o.classes) classOptions += " --class " + shellQuoted(text);
  const Rendering rendering(loaded, classes, plan, o.render);
  const RenderReport report = rendering.report("recurse stills", classOptions);
  Stills stills = makeStills(rendering.film(), stillsPlan, loaded.scene->film().imagingRatio);
  stills.image.metadata = metadataOf(report);
  stills.title = o.render.scene.substr(o.render.scene.find_last_of('/') + 1);
  stills.label = loaded.integratorDirective.type + ", " + formatted("%.4g", report.samplesPerPixel()) +
                 " samples per pixel";
  if (rendering.interrupted()) stills.label += ", interrupted";
  describeStills(stills);
  writeStills(o.folder, stills, other ? &*other : nullptr);
  const std::string folder = o.folder.ends_with('/') ? o.folder : o.folder + "/";
  std::vector<std::string> written;
  for (const char* name : {"stills.exr", "sheet.png", "index.html", "common/*.png", "own/*.png"})
    written.push_back(folder + name);
  if (!o.render.statistics.empty()) {
    writeFileAtomically(o.render.statistics, statisticsJson(report));
    written.push_back(o.render.statistics);
  }
  if (!o.render.quiet) {
    std::fputs(renderSummary(report, written, !o.render.verbose).c_str(), stderr);
    print(stillsTable(stills));
  }
  return rendering.interrupted() ? ExitStatus::INTERRUPTED : ExitStatus::DONE;
}

} // namespace

void addStillsCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<StillsOptions>();
  StillsOptions& o = *options;
  CLI::App* command =
      app.add_subcommand("stills", "Render classes of light paths, each a picture of its own");
  o.render.addSceneTo(*command);
  command
      ->add_option("-o,--output", o.folder,
                   "Folder to write stills.exr, sheet.png, index.html, common/ and own/ to; made if need be")
      ->required()
      ->type_name("DIR");
  command
      ->add_option("--class", o.classes,
                   "A class of paths, such as caustic=LS+DE, several allowed; see 'recurse classes' "
                   "(default: ten that make up the whole picture, and six more where there are media)")
      ->type_name("NAME=EXPR")
      ->expected(1)
      ->take_all();
  command
      ->add_option("--compare", o.compare,
                   "Other stills of the same size, a folder or an EXR file, to compare with on the page")
      ->type_name("DIR|EXR");
  o.render.addTo(*command);
  command->footer(
      "stills.exr has the whole picture in R, G, B and each class in NAME.R, NAME.G, NAME.B. common/ has\n"
      "each class as PNG at the exposure of the whole picture, own/ at one of its own: the 98th percentile "
      "of\n"
      "the luminance of its pixels that are not black is shown as 0.9 of white. sheet.png has all of them\n"
      "with their names, and index.html is a page for a browser. What the given classes leave over becomes\n"
      "the class 'rest'.\n\n"
      "Examples:\n"
      "  recurse stills scene.pbrt -o stills\n"
      "  recurse stills scene.pbrt -o stills --class caustic=LS+DE --class mirrored=LDS+E --spp 64\n"
      "  recurse stills scene.pbrt -o path --integrator path --compare stills");
  command->callback([options, &chosen] { chosen = [options] { return renderStills(*options); }; });
}

} // namespace recurse::apps
