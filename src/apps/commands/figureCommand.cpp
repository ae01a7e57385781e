/** @file
 * `recurse figure`: pictures of the techniques of a method side by side.
 */
#include <algorithm>
#include <atomic>
#include <utility>

#include "apps/commands/commands.h"
#include "apps/figures/figureKinds.h"
#include "apps/options/optionText.h"
#include "apps/run/outputFiles.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/report/figures/figureDrawing.h"

namespace recurse::apps {

namespace {

/** Throws Error (BAD_USAGE) for an option that the figure does not use. */
void checkFigureOptions(const FigureOptions& o, const FigureKind& kind) {
  for (const auto& [name, option] :
       {std::pair("--time-limit", &o.render.timeLimit), std::pair("--error-target", &o.render.errorTarget)})
    if (*option) badUsage(std::string(name) + ": a figure has a number of samples instead: use --spp");
  if (o.render.adaptive) badUsage("--adaptive: each pixel of a figure has the same number of samples");
  if (!o.render.statistics.empty()) badUsage("--stats: a figure has no statistics");
  for (const auto& [name, isGiven] : o.own())
    if (isGiven && std::find(kind.options.begin(), kind.options.end(), name) == kind.options.end())
      badUsage(name + ": 'figure " + o.kind + "' has no such option");
  if (o.render.integrator.named() && kind.method != FigureKind::Method::ANY)
    badUsage("--integrator: 'figure " + o.kind + "' has a method of its own; 'figure cost' takes any");
  if (const std::string text = o.render.integrator.text();
      !text.empty() && kind.method == FigureKind::Method::NONE)
    badUsage(text.substr(1, text.find_first_of(" =", 1) - 1) + ": 'figure " + o.kind + "' has no integrator");
  if (kind.check) kind.check(o);
}

ExitStatus drawFigure(const FigureOptions& o) {
  const FigureKind& kind = figureKind(o.kind);
  checkFigureOptions(o, kind);
  const RenderPlan plan = o.render.plan();
  checkDrawingWritable(o.output);
  const ThreadPool pool(plan.threads);
  const bool takesAny = kind.method == FigureKind::Method::ANY;
  const LoadedScene loaded =
      loadAndBuild(o.render.scene, plan.overrides, takesAny ? o.render.integrator : IntegratorOptions());
  requireDistinctFiles({{"-o", o.output}}, inputFiles("a file of the scene", loaded.files));
  if (o.render.verbose) say(sceneReport(loaded));
  const std::atomic<bool> neverStops{false}; // an interrupt ends the program: there is no part to write
  const FigureDrawing drawing =
      kind.draw({o, loaded, plan.settings(*loaded.scene),
                 o.render.scene.substr(o.render.scene.find_last_of('/') + 1), neverStops});
  writeDrawing(o.output, drawing);
  if (!o.render.quiet) say("written: " + o.output + "\n");
  return ExitStatus::DONE;
}

} // namespace

void addFigureCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<FigureOptions>();
  FigureOptions& o = *options;
  CLI::App* command =
      app.add_subcommand("figure", "Draw the techniques of a method side by side, or the cost of pixels");
  std::string kinds;
  std::vector<std::string> names;
  for (const FigureKind& kind : figureKinds()) {
    kinds += (kinds.empty() ? "" : "; ") + std::string(kind.name) + ": " + kind.description;
    names.push_back(kind.name);
  }
  command->add_option("kind", o.kind, kinds)->required()->type_name("KIND")->check(CLI::IsMember(names));
  o.render.addSceneTo(*command);
  command->add_option("-o,--output", o.output, "Picture to write, or .svg")->required()->type_name("FILE");
  command->add_option("--edges", o.edges, "pyramid: edges of the longest paths, 2 to 12 (default: 5)")
      ->type_name("N");
  command
      ->add_option("--maps", o.maps, "estimate: number of independent photon maps, at least 2 (default: 16)")
      ->type_name("N");
  command
      ->add_option("--offsets", o.offsets,
                   "acne: offsets of shadow rays [scene units] (default: zero, and fractions of the scene's "
                   "radius)")
      ->type_name("D,D...");
  addRepeatedOption(*command, "--pixel", o.pixels,
                    "guide: pixel whose surface point is drawn, may be repeated")
      ->type_name("X,Y");
  command->add_option("--stages", o.stages, "guide: stages of training, 1 to 20 (default: 8)")
      ->type_name("N");
  o.render.addTo(*command);
  command->footer(
      "pyramid: s vertices are sampled from the light and t from the camera. The upper pyramid "
      "has the weighted\n"
      "contributions, which add up to the picture of paths with 2 to N edges; below, each "
      "strategy stands\n"
      "alone. Rows have exposures of their own.\n\n"
      "estimate: maps of all light by photonmap; --spp is the number of paths of path tracing, which "
      "is the\n"
      "truth for the bias. acne: the last picture has the rule of the program.\n"
      "patches: by radiosity; --set patchsize=R sets the longest edge of a patch (default: 0.15 of the\n"
      "scene's radius).\n"
      "guide: by path with guided=true. Discs are the hemisphere above the surface with equal areas for "
      "equal\n"
      "solid angles, the camera at the bottom; --spp is the number of rays and of paths for each of their "
      "7238\n"
      "cells on average. --stages N is the guide of samples 2^(N-1) to 2^N - 1 of a render, counted from 0; "
      "training\n"
      "ends at 200,000 records.\n\n"
      "Examples:\n"
      "  recurse figure pyramid scene.pbrt -o pyramid.png --resolution 160x160 --spp 16\n"
      "  recurse figure mis scene.pbrt -o mis.png --spp 4\n"
      "  recurse figure samplings scene.pbrt -o samplings.svg --spp 64\n"
      "  recurse figure estimate scene.pbrt -o estimate.png --photons 100k --spp 256\n"
      "  recurse figure acne scene.pbrt -o acne.png --offsets 0,1e-6,1e-3,.1\n"
      "  recurse figure patches scene.pbrt -o patches.png --set patchsize=.2\n"
      "  recurse figure guide scene.pbrt -o guide.png --pixel 320,200 --spp 64\n"
      "  recurse figure cost scene.pbrt -o cost.png --integrator photonmap");
  command->callback([options, &chosen] { chosen = [options] { return drawFigure(*options); }; });
}

} // namespace recurse::apps
