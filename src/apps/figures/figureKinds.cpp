/** @file
 * Drawings of the kinds of figures.
 */
#include "apps/figures/figureKinds.h"

#include <algorithm>
#include <cmath>

#include "apps/options/optionText.h"
#include "recurse/core/threads/resources.h"
#include "recurse/report/directions/guideFigure.h"

namespace recurse::apps {

namespace {

/** Default number of edges of the longest paths of a pyramid. */
constexpr int DEFAULT_EDGES = 5;

int edgesOf(const FigureOptions& o) {
  return o.edges ? static_cast<int>(parseCount("--edges", *o.edges, 2, 12)) : DEFAULT_EDGES;
}

FigureDrawing drawPyramid(const FigureRun& run) {
  const int edges = edgesOf(run.options);
  const std::unique_ptr<Integrator> bidirectional = run.integrator("bdpt");
  const std::unique_ptr<Integrator> lightPaths = run.integrator("lightpath");
  const int strategyCount = (edges + 1) * (edges + 2) / 2 - 3; // the sum of 3, 4 … edges + 1
  run.requireMemoryFor(2 * strategyCount, 2 * (edges - 1) * (edges + 1), edges - 1);
  const auto strategies =
      strategyPictures(*run.loaded.scene, *bidirectional, *lightPaths, run.settings, edges, run.stop);
  std::vector<FigurePanel> panels = pyramidPanels(strategies, true);
  for (FigurePanel& panel : pyramidPanels(strategies, false)) {
    panel.row += edges - 1; // below the weighted ones
    panel.name += " alone";
    panels.push_back(std::move(panel));
  }
  return figureSheet("strategies of bidirectional path tracing",
                     run.subtitle() + ", a row for each number of edges", panels);
}

FigureDrawing drawMis(const FigureRun& run) {
  run.requireMemoryFor(5, 6);
  return figureSheet("multiple importance sampling", run.subtitle(),
                     misPanels(*run.loaded.scene, *run.integrator("path"), run.settings, run.stop));
}

FigureDrawing drawSamplings(const FigureRun& run) {
  run.requireMemoryFor(5, 5);
  const SamplingsFigure figure =
      samplingsFigure(*run.loaded.scene, run.settings.samplesPerPixel, run.settings.seed, run.stop);
  return figureSheet("samplings of direct light", run.subtitle(), figure.panels, &figure.plot);
}

int mapsOf(const FigureOptions& o) {
  constexpr int DEFAULT_MAPS = 16;
  return o.maps ? static_cast<int>(parseCount("--maps", *o.maps, 2, 1000000)) : DEFAULT_MAPS;
}

void checkEstimate(const FigureOptions& o) {
  mapsOf(o);
  const std::string text = o.render.integrator.text();
  for (const std::string option : {"--direct", "--set passes=", "--set finalgather=", "--set direct="})
    if (text.find(" " + option) != std::string::npos)
      badUsage(option.substr(0, option.find('=')) +
               ": 'figure estimate' has one map of all light in each pass, without final gathering");
}

/** Replaces or adds a parameter. */
void setParameter(ParsedDirective& directive, ParsedParameter parameter) {
  std::erase_if(directive.parameters, [&](const ParsedParameter& p) { return p.name == parameter.name; });
  directive.parameters.push_back(std::move(parameter));
}

ParsedParameter integerValue(const std::string& name, double value) {
  ParsedParameter p;
  p.type = "integer";
  p.name = name;
  p.numbers = {value};
  return p;
}

FigureDrawing drawEstimate(const FigureRun& run) {
  const int maps = mapsOf(run.options);
  if (run.settings.samplesPerPixel < 2) badUsage("--spp: a standard error needs at least 2 paths of a pixel");
  run.requireMemoryFor(12, 12);
  ParsedDirective photonMap = run.directive("photonmap"), path = photonMap;
  setParameter(photonMap, integerValue("passes", 1));
  setParameter(photonMap, integerValue("finalgather", 0));
  ParsedParameter direct;
  direct.type = "string";
  direct.name = "direct";
  direct.strings = {"photons"};
  setParameter(photonMap, direct);
  path.type = "path";
  std::erase_if(path.parameters, [](const ParsedParameter& p) { return p.name != "maxdepth"; });
  const EstimateFigure figure =
      estimateFigure(*run.loaded.scene, {[&] { return run.made(photonMap); }, [&] { return run.made(path); }},
                     maps, run.settings.samplesPerPixel, run.settings.seed, run.stop);
  return figureSheet("layers of a photon estimate",
                     run.scene +
                         formatted(", RMS bias %.2g and standard deviation %.2g of the mean; standard "
                                   "error of the bias %.2g",
                                   std::sqrt(std::max(0.0, figure.squaredBias)), std::sqrt(figure.variance),
                                   figure.biasError),
                     figure.panels);
}

/** Offsets of --offsets; empty: the default. */
std::vector<float> offsetsOf(const FigureOptions& o) {
  std::vector<float> offsets;
  if (!o.offsets) return offsets;
  for (const std::string& text : split(*o.offsets, ',')) {
    const double offset = parseReal("--offsets", text);
    if (!(offset >= 0)) badUsage("--offsets: " + text + " is below 0");
    offsets.push_back(static_cast<float>(offset));
  }
  return offsets;
}

FigureDrawing drawAcne(const FigureRun& run) {
  std::vector<float> offsets = offsetsOf(run.options);
  if (offsets.empty()) offsets = defaultOffsets(*run.loaded.scene);
  const auto count = static_cast<int>(offsets.size()) + 1;
  run.requireMemoryFor(count, count + 3);
  return figureSheet("origin of shadow rays",
                     run.subtitle() + ", offsets in scene units, wrong shadow rays in percent",
                     acnePanels(acnePictures(*run.loaded.scene, offsets, run.settings.samplesPerPixel,
                                             run.settings.seed, run.stop)));
}

FigureDrawing drawPatches(const FigureRun& run) {
  constexpr double DEFAULT_SIZE = 0.15; // of the scene's radius
  run.requireMemoryFor(3, 3, 2);
  ParsedDirective directive = run.directive("radiosity");
  if (std::none_of(directive.parameters.begin(), directive.parameters.end(),
                   [](const ParsedParameter& p) { return p.name == "patchsize"; })) {
    ParsedParameter size;
    size.type = "float";
    size.name = "patchsize";
    size.numbers = {DEFAULT_SIZE * double(run.loaded.scene->bounds().radius)};
    directive.parameters.push_back(size);
  }
  return figureSheet("radiosity", run.subtitle(),
                     patchesPanels(*run.loaded.scene, *run.made(directive), run.settings, run.stop));
}

int stagesOf(const FigureOptions& o) {
  constexpr int DEFAULT_STAGES = 8;
  return o.stages ? static_cast<int>(parseCount("--stages", *o.stages, 1, 20)) : DEFAULT_STAGES;
}

void checkGuide(const FigureOptions& o) {
  stagesOf(o);
  if (o.pixels.empty()) badUsage("--pixel X,Y: 'figure guide' draws the directions at single pixels");
  if (o.render.integrator.text().find(" --set guided=") != std::string::npos)
    badUsage("--set guided: 'figure guide' always guides");
}

FigureDrawing drawGuide(const FigureRun& run) {
  const Scene& scene = *run.loaded.scene;
  std::vector<std::array<int, 2>> pixels;
  for (const std::string& text : run.options.pixels)
    pixels.push_back(parsePixel("--pixel", text, scene.film().crop));
  ParsedDirective path = run.directive("path");
  ParsedParameter guided;
  guided.type = "bool";
  guided.name = "guided";
  guided.booleans = {true};
  setParameter(path, guided);
  const GuideFigure figure = guideFigure(scene, *run.made(path), pixels, stagesOf(run.options),
                                         run.settings.samplesPerPixel, run.settings.seed, run.stop);
  return figureSheet("directions of light",
                     run.scene + formatted(", rays of a cell: %d; ", run.settings.samplesPerPixel) +
                         guideText(figure.guide),
                     guidePanels(figure));
}

FigureDrawing drawCost(const FigureRun& run) {
  run.requireMemoryFor(3, 3);
  const int64_t samples = samplesTaken(*run.loaded.integrator, run.settings);
  return figureSheet("cost of a sample", run.subtitle(samples) + ", " + run.loaded.integratorDirective.type,
                     costPanels(*run.loaded.scene, *run.loaded.integrator, run.settings, run.stop));
}

} // namespace

ParsedDirective FigureRun::directive(const std::string& type) const {
  IntegratorOptions own = options.render.integrator;
  own.setIntegrator(type);
  return own.directive(loaded.integratorDirective);
}

std::unique_ptr<Integrator> FigureRun::made(const ParsedDirective& directive) const {
  Diagnostics diagnostics;
  std::unique_ptr<Integrator> made = makeIntegrator(directive, options.render.lenient, diagnostics);
  diagnostics.throwIfErrors();
  if (const std::string unsupported = unsupportedPart(*made, *loaded.scene); !unsupported.empty())
    throw Error("the figure needs the integrator " + directive.type + ", which cannot render " + unsupported);
  return made;
}

void FigureRun::requireMemoryFor(int panels, int cells, int layers) const {
  const PixelBounds& crop = loaded.scene->film().crop;
  // There are films and pictures during the render, then two copies of each picture and the sheet.
  const double pixels = double(crop.area()), picture = 3 * sizeof(float) * pixels;
  const double film = Film::bytes(pixels, layers) + SplatPlane::bytes(pixels, layers);
  requireMemory("a figure of " + std::to_string(panels) + " pictures of " + std::to_string(crop.width()) +
                    "x" + std::to_string(crop.height()) + " pixels",
                std::max(panels * picture + 2 * film, (2 * panels + cells) * picture));
}

const std::vector<FigureKind>& figureKinds() {
  using Method = FigureKind::Method;
  static const std::vector<FigureKind> KINDS = {
      {"pyramid",
       "strategies of bidirectional path tracing",
       Method::OWN,
       {"--edges"},
       [](const FigureOptions& o) { edgesOf(o); },
       drawPyramid},
      {"mis", "light samples, BSDF samples, and both", Method::OWN, {}, nullptr, drawMis},
      {"samplings",
       "direct light by uniform, cosine, BSDF and light sampling and by both, with their errors",
       Method::NONE,
       {},
       nullptr,
       drawSamplings},
      {"estimate",
       "number, radius, bias and variance of a photon estimate",
       Method::OWN,
       {"--maps"},
       checkEstimate,
       drawEstimate},
      {"acne",
       "shadow acne and light leaks by the offset of shadow rays",
       Method::NONE,
       {"--offsets"},
       [](const FigureOptions& o) { offsetsOf(o); },
       drawAcne},
      {"patches",
       "patches of radiosity, and their light interpolated",
       Method::OWN,
       {},
       nullptr,
       drawPatches},
      {"guide",
       "directions of light at a pixel, and the densities that path guiding samples",
       Method::OWN,
       {"--pixel", "--stages"},
       checkGuide,
       drawGuide},
      {"cost", "rays, photons and time of a sample", Method::ANY, {}, nullptr, drawCost},
  };
  return KINDS;
}

const FigureKind& figureKind(const std::string& name) {
  return *std::find_if(figureKinds().begin(), figureKinds().end(),
                       [&](const FigureKind& kind) { return kind.name == name; });
}

} // namespace recurse::apps
