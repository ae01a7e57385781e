/** @file
 * `recurse figure`: pictures of the techniques of a method side by side.
 */
#include <algorithm>
#include <optional>
#include <utility>

#include "apps/commands/commands.h"
#include "apps/options/optionText.h"
#include "apps/options/renderOptions.h"
#include "apps/run/outputFiles.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/core/threads/resources.h"
#include "recurse/report/figures/figures.h"

namespace recurse::apps {

namespace {

struct FigureOptions {
  RenderOptions render;
  std::string kind, output;
  std::optional<std::string> edges;
};

/** Default number of edges of the longest paths of a pyramid. */
constexpr int DEFAULT_EDGES = 5;

/** Throws Error (BAD_USAGE) for an option that the figure does not use. */
void checkOptions(const FigureOptions& o) {
  for (const auto& [name, option] :
       {std::pair("--time-limit", &o.render.timeLimit), std::pair("--error-target", &o.render.errorTarget)})
    if (*option) badUsage(std::string(name) + ": a figure has a number of samples instead: use --spp");
  if (o.render.adaptive) badUsage("--adaptive: each pixel of a figure has the same number of samples");
  if (!o.render.statistics.empty()) badUsage("--stats: a figure has no statistics");
  if (o.edges && o.kind != "pyramid") badUsage("--edges: only the pyramid has edges");
  if (o.render.integrator.named() && o.kind != "cost")
    badUsage("--integrator: 'figure " + o.kind + "' has a method of its own; 'figure cost' takes any");
}

/** Makes the integrator, with those parameters of the scene and of the options that it takes. */
std::unique_ptr<Integrator> integratorNamed(const std::string& type, const FigureOptions& o,
                                            const LoadedScene& loaded) {
  IntegratorOptions options = o.render.integrator;
  options.setIntegrator(type);
  Diagnostics diagnostics;
  std::unique_ptr<Integrator> made =
      makeIntegrator(options.directive(loaded.integratorDirective), o.render.lenient, diagnostics);
  diagnostics.throwIfErrors();
  if (const std::string unsupported = unsupportedPart(*made, *loaded.scene); !unsupported.empty())
    throw Error("the figure needs the integrator " + type + ", which cannot render " + unsupported);
  return made;
}

/** Throws Error where the memory is too small for a figure with this number of panels on a sheet of `cells`
 * places. There are films and pictures during the render, then two copies of each picture and the sheet. */
void requireFigureMemory(const Scene& scene, int panels, int cells, int layers) {
  const PixelBounds& crop = scene.film().crop;
  const double pixels = double(crop.area()), picture = 3 * sizeof(float) * pixels;
  const double film = Film::bytes(pixels, layers) + SplatPlane::bytes(pixels, layers);
  requireMemory("a figure of " + std::to_string(panels) + " pictures of " + std::to_string(crop.width()) +
                    "x" + std::to_string(crop.height()) + " pixels",
                std::max(panels * picture + 2 * film, (2 * panels + cells) * picture));
}

Image pyramidOf(const FigureOptions& o, const LoadedScene& loaded, const RenderSettings& settings,
                const std::string& scene, const std::atomic<bool>& stop) {
  const auto edges = o.edges ? static_cast<int>(parseCount("--edges", *o.edges, 2, 12)) : DEFAULT_EDGES;
  const std::unique_ptr<Integrator> bidirectional = integratorNamed("bdpt", o, loaded);
  const std::unique_ptr<Integrator> lightPaths = integratorNamed("lightpath", o, loaded);
  const int strategyCount = (edges + 1) * (edges + 2) / 2 - 3; // the sum of 3, 4 … edges + 1
  requireFigureMemory(*loaded.scene, 2 * strategyCount, 2 * (edges - 1) * (edges + 1), edges - 1);
  const auto strategies = strategyPictures(*loaded.scene, *bidirectional, *lightPaths, settings, edges, stop);
  std::vector<FigurePanel> panels = pyramidPanels(strategies, true);
  for (FigurePanel& panel : pyramidPanels(strategies, false)) {
    panel.row += edges - 1; // below the weighted ones
    panel.name += " alone";
    panels.push_back(std::move(panel));
  }
  return figureSheet("strategies of bidirectional path tracing", scene + ", a row for each number of edges",
                     panels);
}

ExitStatus drawFigure(const FigureOptions& o) {
  checkOptions(o);
  const RenderPlan plan = o.render.plan();
  if (o.edges) parseCount("--edges", *o.edges, 2, 12); // before the scene is loaded
  checkImageWritable(o.output);
  const ThreadPool pool(plan.threads);
  const bool isCost = o.kind == "cost";
  const LoadedScene loaded =
      loadAndBuild(o.render.scene, plan.overrides, isCost ? o.render.integrator : IntegratorOptions());
  requireDistinctFiles({{"-o", o.output}}, inputFiles("a file of the scene", loaded.files));
  if (o.render.verbose) say(sceneReport(loaded));
  const Scene& scene = *loaded.scene;
  const RenderSettings settings = plan.settings(scene);
  const std::string name = o.render.scene.substr(o.render.scene.find_last_of('/') + 1);
  const int64_t samples = isCost ? samplesTaken(*loaded.integrator, settings) : settings.samplesPerPixel;
  const std::string title = name + ", " + std::to_string(samples) + " samples per pixel";
  const GracefulStop graceful;
  Image sheet;
  if (o.kind == "pyramid") {
    sheet = pyramidOf(o, loaded, settings, title, graceful.flag());
  } else if (o.kind == "mis") {
    requireFigureMemory(scene, 5, 6, 1);
    sheet = figureSheet("multiple importance sampling", title,
                        misPanels(scene, *integratorNamed("path", o, loaded), settings, graceful.flag()));
  } else {
    requireFigureMemory(scene, 3, 3, 1);
    sheet = figureSheet("cost of a sample", title + ", " + loaded.integratorDirective.type,
                        costPanels(scene, *loaded.integrator, settings, graceful.flag()));
  }
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
                  "contributions, which add up to the picture of paths with 2 to N edges; below, each "
                  "strategy stands\n"
                  "alone. Rows have exposures of their own.\n\n"
                  "Examples:\n"
                  "  recurse figure pyramid scene.pbrt -o pyramid.png --resolution 160x160 --spp 16\n"
                  "  recurse figure mis scene.pbrt -o mis.png --spp 4\n"
                  "  recurse figure cost scene.pbrt -o cost.png --integrator photonmap");
  command->callback([options, &chosen] { chosen = [options] { return drawFigure(*options); }; });
}

} // namespace recurse::apps
