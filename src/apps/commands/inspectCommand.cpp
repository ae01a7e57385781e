/** @file
 * `recurse inspect`: a page of a scene in 3D with the paths of pixels and the photons.
 */
#include <algorithm>
#include <atomic>

#include "apps/commands/commands.h"
#include "apps/options/optionText.h"
#include "apps/options/renderOptions.h"
#include "apps/run/outputFiles.h"
#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/text.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/pathclasses/pathExpression.h"
#include "recurse/report/inspect/formFactors.h"
#include "recurse/report/inspect/inspect.h"
#include "recurse/report/stills/stills.h"
#include "recurse/transport/integrator/sceneNames.h"

namespace recurse::apps {

namespace {

struct InspectOptions {
  RenderOptions render;
  std::string output;
  std::vector<std::string> pixels, classes;
  std::string pathSamples = "16", shownPhotons = "100k", shownLightPaths = "2000", referenceSamples = "4096";
};

/** Default grid of recorded pixels. */
constexpr int GRID_COLUMNS = 6, GRID_ROWS = 4;

std::vector<RecordedPixel> pixelsOf(const InspectOptions& o, const PixelBounds& crop) {
  std::vector<RecordedPixel> pixels;
  for (const std::string& text : o.pixels) {
    RecordedPixel pixel;
    const auto [x, y] = parsePixel("--pixel", text, crop);
    pixel.x = x;
    pixel.y = y;
    pixels.push_back(std::move(pixel));
  }
  if (!pixels.empty()) return pixels;
  const int columns = std::min(GRID_COLUMNS, crop.width()), rows = std::min(GRID_ROWS, crop.height());
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      RecordedPixel pixel;
      pixel.x = crop.x0 + (2 * i + 1) * crop.width() / (2 * columns);
      pixel.y = crop.y0 + (2 * j + 1) * crop.height() / (2 * rows);
      pixels.push_back(std::move(pixel));
    }
  return pixels;
}

/** Index of a pixel on the film of a crop window. */
size_t pixelIndex(const PixelBounds& crop, const RecordedPixel& pixel) {
  return size_t(pixel.y - crop.y0) * size_t(crop.width()) + size_t(pixel.x - crop.x0);
}

InspectClasses classesOf(const InspectOptions& o, const LoadedScene& loaded) {
  std::vector<PathClass> classes;
  for (const std::string& text : o.classes) classes.push_back(parseClass("--class", text));
  if (classes.empty()) classes = defaultStillClasses(loaded.scene->hasMedia());
  const PathNames names = pathNames(*loaded.scene, loaded.integrator.get());
  return inspectClasses(planStills(classes, &names).classes, *loaded.scene, loaded.integrator.get(),
                        size_t(loaded.scene->film().crop.area()));
}

/** Irradiance by `path` at the recorded pixels, of the light that the photons carry. */
std::vector<ReferencePoint> referencesOf(const LoadedScene& loaded, const PathClasses& classes,
                                         const Inspection& inspection, int64_t samples, uint64_t seed,
                                         const std::atomic<bool>& stop) {
  const std::string expression =
      photonExpression(classes, inspection.photons, loaded.integrator->photonPaths(), inspection.kinds,
                       inspection.shownClasses);
  if (samples == 0 || inspection.photons.empty() || expression.empty()) return {};
  ParsedDirective directive;
  directive.type = "path";
  directive.location = loaded.integratorDirective.location;
  for (const ParsedParameter& p : loaded.integratorDirective.parameters)
    if (p.name == "maxdepth") directive.parameters.push_back(p);
  Diagnostics diagnostics;
  const std::unique_ptr<Integrator> path = makeIntegrator(directive, false, diagnostics);
  diagnostics.throwIfErrors();
  const PathClasses ofPhotons = sceneClasses({{"photons", expression}}, *loaded.scene, path.get());
  path->prepare(*loaded.scene, ofPhotons);
  ForwardControl control;
  control.stop = &stop;
  path->forward(*loaded.scene, ofPhotons, {.seed = seed}, control);
  return referencePoints(*loaded.scene, *path, ofPhotons, inspection.pixels, samples, seed, stop);
}

/** Adds the patches of radiosity and their form factors, if the integrator has them. */
void addPatches(const LoadedScene& loaded, bool quiet, uint64_t seed, const std::atomic<bool>& stop,
                Inspection& inspection) {
  loaded.integrator->visitPatches([&](const RadiosityPatch& patch) { inspection.patches.push_back(patch); });
  const size_t count = inspection.patches.size();
  inspection.factorRays = formFactorRays(count);
  if (inspection.factorRays == 0 && !quiet)
    say(formatted("note: the page has no form factors: more than %zu patches (%zu); a larger patchsize makes "
                  "fewer\n",
                  MOST_FACTOR_PATCHES, count));
  inspection.factors =
      formFactors(*loaded.scene, *loaded.integrator, inspection.patches, inspection.factorRays, seed, stop);
}

ExitStatus inspectScene(const InspectOptions& o) {
  const RenderPlan plan = o.render.plan();
  const int64_t samples = parseCount("--path-samples", o.pathSamples, 1, 100000);
  const auto photons = static_cast<size_t>(parseCount("--shown-photons", o.shownPhotons, 0, 100000000));
  const auto lightPaths =
      static_cast<uint64_t>(parseCount("--shown-light-paths", o.shownLightPaths, 0, 1000000));
  const int64_t referenceSamples = parseCount("--reference-samples", o.referenceSamples, 0, 100000000);
  if (referenceSamples == 1)
    badUsage("--reference-samples: a standard error needs at least 2 samples; 0: none");
  if (!lowerCase(o.output).ends_with(".html"))
    badUsage("-o " + o.output + ": the output is a page, such as look.html");
  checkFileWritable(o.output);
  if (!o.render.statistics.empty()) checkFileWritable(o.render.statistics);
  const ThreadPool pool(plan.threads);
  LoadedScene loaded = loadAndBuild(o.render.scene, plan.overrides, o.render.integrator);
  requireDistinctFiles({{"-o", o.output}, {"--stats", o.render.statistics}},
                       inputFiles("a file of the scene", loaded.files));
  const Scene& scene = *loaded.scene;
  const InspectClasses all = classesOf(o, loaded);
  const PathClasses& classes = all.classes;
  Inspection inspection;
  inspection.shownClasses = all.shown;
  inspection.lamps = all.lamps;
  inspection.depths = all.depths;
  inspection.pixels = pixelsOf(o, scene.film().crop);
  inspection.lightPaths = LightPathRecorder(lightPaths);

  std::string statistics;
  {
    const RenderResult result = renderLoaded(loaded, PathClasses(), plan, o.render);
    if (result.isInterrupted()) return ExitStatus::INTERRUPTED;
    const RenderReport report = result.report("recurse inspect");
    inspection.picture = pictureOf(result.film, report);
    if (const SplatPlane* splats = result.film.splats())
      for (RecordedPixel& pixel : inspection.pixels)
        pixel.splats = splats->value(pixelIndex(scene.film().crop, pixel), 0);
    inspection.label = loaded.integratorDirective.type + ", " + formatted("%.4g", report.samplesPerPixel()) +
                       " samples per pixel";
    statistics = statisticsJson(report);
  }
  replaceIntegrator(loaded, o.render.integrator, o.render.lenient, false);
  const std::atomic<bool> neverStops{false}; // an interrupt ends the program: there is no part to write
  recordPixels(scene, *loaded.integrator, classes, plan.settings(scene), samples, inspection.pixels,
               neverStops, {}, &inspection.lightPaths);
  inspection.photons = photonsOf(*loaded.integrator, photons, inspection.photonsInMap);
  inspection.kinds = surfaceKindsOf(scene, classes, inspection.photons);
  inspection.shownPhotons = photons;
  inspection.notes = recordNotes(*loaded.integrator);
  inspection.photonName = loaded.integrator->photonName();
  loaded.integrator->visitPhotonBoxes(BOX_LEVELS,
                                      [&](const PhotonBox& box) { inspection.boxes.push_back(box); });
  addPatches(loaded, o.render.quiet, plan.settings(scene).seed, neverStops, inspection);
  inspection.references =
      referencesOf(loaded, classes, inspection, referenceSamples, plan.settings(scene).seed, neverStops);
  inspection.title = o.render.scene.substr(o.render.scene.find_last_of('/') + 1);
  const std::string page = inspectPage(scene, classes, inspection);
  writeFileAtomically(o.output, page);
  if (!o.render.statistics.empty()) writeFileAtomically(o.render.statistics, statistics);
  if (!o.render.quiet)
    say("recorded: " + std::to_string(inspection.pixels.size()) + " pixels, " +
        std::to_string(inspection.photons.size()) + " of " + std::to_string(inspection.photonsInMap) + " " +
        inspection.photonName + " of the last pass, " +
        std::to_string(inspection.lightPaths.pathsRecorded()) +
        " light paths, irradiance by path tracing at " + std::to_string(inspection.references.size()) +
        " points\nwritten: " + o.output + ", " + bytesText(double(page.size())) + "\n");
  return ExitStatus::DONE;
}

} // namespace

void addInspectCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<InspectOptions>();
  InspectOptions& o = *options;
  CLI::App* command =
      app.add_subcommand("inspect", "Write a page with the scene in 3D, the paths of pixels and the photons");
  o.render.addSceneTo(*command);
  command->add_option("-o,--output", o.output, "Page to write, .html")->required()->type_name("FILE");
  addRepeatedOption(*command, "--pixel", o.pixels,
                    "Pixel to record paths of, may be repeated (default: a grid of 24 pixels)")
      ->type_name("X,Y");
  command
      ->add_option("--path-samples", o.pathSamples,
                   "Number of samples to record for each pixel (default: 16)")
      ->type_name("N");
  command
      ->add_option("--shown-photons", o.shownPhotons,
                   "Maximum number of photons to show, from the integrator's last map (default: 100k)")
      ->type_name("N");
  command
      ->add_option("--shown-light-paths", o.shownLightPaths,
                   "Maximum number of light paths to animate, of the integrator's last pass (default: 2000)")
      ->type_name("N");
  command
      ->add_option(
          "--reference-samples", o.referenceSamples,
          "Number of samples of path tracing for the irradiance at each recorded pixel, which density "
          "estimates are compared with, at least 2; 0: none (default: 4096)")
      ->type_name("N");
  addRepeatedOption(*command, "--class", o.classes,
                    "A class of paths, such as caustic=LS+DE; may be repeated; see 'recurse classes' "
                    "(default: the classes of 'recurse stills')")
      ->type_name("NAME=EXPR");
  o.render.addTo(*command);
  command->footer(
      "The page needs no network. Click a marked pixel of the picture to draw the paths that the\n"
      "integrator sampled for it, coloured by class, with a table of their vertices and contributions.\n"
      "Click a surface to show the photons around that point and their density estimate, and a marked\n"
      "point to compare it with path tracing. Play the flight of the photons, and show the boxes of the\n"
      "photon map's tree. With --integrator radiosity, click a patch to show its form factors.\n\n"
      "Examples:\n"
      "  recurse inspect scene.pbrt -o look.html\n"
      "  recurse inspect scene.pbrt -o look.html --integrator path --pixel 100,80 --pixel 20,7\n"
      "  recurse inspect scene.pbrt -o look.html --shown-photons 1M --spp 4");
  command->callback([options, &chosen] { chosen = [options] { return inspectScene(*options); }; });
}

} // namespace recurse::apps
