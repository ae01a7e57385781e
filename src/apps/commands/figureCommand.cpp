/** @file
 * `recurse figure`: pictures of the techniques of a method side by side.
 */
#include "apps/commands/commands.h"
#include "apps/options/optionText.h"
#include "apps/options/renderOptions.h"
#include "apps/run/outputFiles.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/report/figures/figures.h"

namespace recurse::apps {

namespace {

struct FigureOptions {
  RenderOptions render;
  std::string kind, output, edges = "5";
};

std::unique_ptr<Integrator> integratorNamed(const std::string& type, const LoadedScene& loaded) {
  ParsedDirective directive;
  directive.type = type;
  directive.location = loaded.integratorDirective.location;
  Diagnostics diagnostics;
  std::unique_ptr<Integrator> made = makeIntegrator(directive, false, diagnostics);
  diagnostics.throwIfErrors();
  if (const std::string unsupported = unsupportedPart(*made, *loaded.scene); !unsupported.empty())
    throw Error("the figure needs the integrator " + type + ", which cannot render " + unsupported);
  return made;
}

Image pyramidOf(const LoadedScene& loaded, const RenderSettings& settings, int edges,
                const std::string& title, const std::atomic<bool>& stop) {
  const std::unique_ptr<Integrator> bidirectional = integratorNamed("bdpt", loaded);
  const std::unique_ptr<Integrator> lightPaths = integratorNamed("lightpath", loaded);
  const auto strategies = strategyPictures(*loaded.scene, *bidirectional, *lightPaths, settings, edges, stop);
  std::vector<FigurePanel> panels = pyramidPanels(strategies, true);
  for (FigurePanel& panel : pyramidPanels(strategies, false)) {
    panel.row += edges - 1; // below the weighted ones
    panel.name += " alone";
    panels.push_back(std::move(panel));
  }
  return figureSheet("strategies of bidirectional path tracing", title + ", a row for each number of edges",
                     panels);
}

ExitStatus drawFigure(const FigureOptions& o) {
  const RenderPlan plan = o.render.plan();
  const auto edges = static_cast<int>(parseCount("--edges", o.edges, 2, 12));
  checkImageWritable(o.output);
  const ThreadPool pool(plan.threads);
  LoadedScene loaded = loadAndBuild(o.render.scene, plan.overrides, o.render.integrator);
  requireDistinctFiles({{"-o", o.output}}, inputFiles("a file of the scene", loaded.files));
  const Scene& scene = *loaded.scene;
  const RenderSettings settings = plan.settings(scene);
  const std::string name = o.render.scene.substr(o.render.scene.find_last_of('/') + 1);
  const std::string title = name + ", " + std::to_string(settings.samplesPerPixel) + " samples per pixel";
  const GracefulStop graceful;
  Image sheet;
  if (o.kind == "pyramid")
    sheet = pyramidOf(loaded, settings, edges, title, graceful.flag());
  else if (o.kind == "mis")
    sheet = figureSheet("multiple importance sampling", title,
                        misPanels(scene, *integratorNamed("path", loaded), settings, graceful.flag()));
  else
    sheet = figureSheet("cost of a sample", title + ", " + loaded.integratorDirective.type,
                        costPanels(scene, *loaded.integrator, settings, graceful.flag()));
  if (graceful.flag()) return ExitStatus::INTERRUPTED;
  writeImage(o.output, sheet);
  if (!o.render.quiet) say("written: " + o.output + "\n");
  return ExitStatus::DONE;
}

} // namespace

void addFigureCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<FigureOptions>();
  FigureOptions& o = *options;
  CLI::App* command =
      app.add_subcommand("figure", "Draw the techniques of a method side by side, or the cost of pixels");
  command
      ->add_option("kind", o.kind,
                   "pyramid: strategies of bidirectional path tracing; mis: light samples, BSDF "
                   "samples, and both; cost: rays, photons and time of a sample")
      ->required()
      ->type_name("KIND")
      ->check(CLI::IsMember({"pyramid", "mis", "cost"}));
  o.render.addSceneTo(*command);
  command->add_option("-o,--output", o.output, "Picture to write")->required()->type_name("FILE");
  command->add_option("--edges", o.edges, "pyramid: edges of the longest paths, 2 to 12 (default: 5)")
      ->type_name("N");
  o.render.addTo(*command);
  command->footer("pyramid: s vertices are sampled from the light and t from the camera. The upper pyramid "
                  "has the weighted\n"
                  "contributions, which add up to the picture; below, each strategy stands alone. Rows have "
                  "exposures of\n"
                  "their own.\n\n"
                  "Examples:\n"
                  "  recurse figure pyramid scene.pbrt -o pyramid.png --resolution 160x160 --spp 16\n"
                  "  recurse figure mis scene.pbrt -o mis.png --spp 4\n"
                  "  recurse figure cost scene.pbrt -o cost.png --integrator photonmap");
  command->callback([options, &chosen] { chosen = [options] { return drawFigure(*options); }; });
}

} // namespace recurse::apps
