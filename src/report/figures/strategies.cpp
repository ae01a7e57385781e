/** @file
 * Strategies of bidirectional path tracing.
 */
#include <algorithm>
#include <bit>
#include <string>

#include "recurse/report/figures/figures.h"
#include "recurse/report/stills/stills.h"
#include "report/figures/techniquePictures.h"

namespace recurse {

namespace {

constexpr int SHORTEST = 2; ///< edges of the shortest paths shown; paths of one edge have one strategy only

/** Classes of paths by their number of edges, from SHORTEST to `longest`. */
PathClasses classesByLength(int longest) {
  std::vector<PathClass> classes;
  for (int edges = SHORTEST; edges <= longest; ++edges)
    classes.push_back({std::to_string(edges) + " edges", "L(S|D|V){" + std::to_string(edges - 1) + "}E"});
  return PathClasses(classes);
}

/** Strategies with s light vertices for each length: s = 0 … edges. */
int strategyIndex(int edges, int lightVertices) {
  int index = 0;
  for (int shorter = SHORTEST; shorter < edges; ++shorter) index += shorter + 1;
  return index + lightVertices;
}

/** Number of vertices that are sampled from the light. Light samples pass panes without vertices of their
 * own. */
int lightVertices(const PathRecorder& record, const RecordedSource& source) {
  if (source.technique == PathTechnique::HIT) return 0;
  if (source.technique == PathTechnique::LIGHT_SAMPLE) return 1;
  int count = 0;
  for (int i = source.lightVertex; i != NOT_RECORDED; i = record.lightVertices[size_t(i)].previous) ++count;
  return count;
}

void divide(Image& image, int x, int y, float by) {
  for (int c = 0; c < 3; ++c) image.at(x, y)[c] /= by;
}

/** Picture of the splats of one layer. */
Image splatsOf(const Film& film, size_t layer) {
  Image image(film.bounds().width(), film.bounds().height(), {"R", "G", "B"});
  for (size_t p = 0; p < film.bounds().area(); ++p) {
    const Rgb value = film.splats()->value(p, layer);
    for (size_t c = 0; c < 3; ++c) image.pixels[3 * p + c] = value[int(c)];
  }
  return image;
}

} // namespace

std::vector<StrategyPictures> strategyPictures(const Scene& scene, Integrator& bidirectional,
                                               Integrator& lightPaths, const RenderSettings& settings,
                                               int longest, const std::atomic<bool>& stop) {
  const PathClasses classes = classesByLength(longest);
  const PixelBounds& crop = scene.film().crop;
  std::vector<StrategyPictures> out;
  for (int edges = SHORTEST; edges <= longest; ++edges)
    for (int s = 0; s <= edges; ++s) out.push_back({s, edges + 1 - s, {}, {}});
  std::vector<Image> weighted(out.size(), Image(crop.width(), crop.height(), {"R", "G", "B"})),
      unweighted = weighted;
  Image weights(crop.width(), crop.height(), {"Y"});
  const auto which = [&](const PathRecorder& record, const RecordedContribution& c) {
    if (c.classes == 0) return -1;
    const int edges = SHORTEST + std::countr_zero(c.classes);
    return strategyIndex(edges, lightVertices(record, c.source));
  };
  Film film(crop, classes.layerCount());
  visitRecords(
      scene, bidirectional, classes, settings, film, stop, [&](int x, int y, const PathRecorder& record) {
        const int i = x - crop.x0, j = y - crop.y0;
        addContributions(scene.film(), record, i, j, weighted, which,
                         [](const PathRecorder&, const RecordedContribution& c) { return c.radiance; });
        addContributions(scene.film(), record, i, j, unweighted, which,
                         [](const PathRecorder&, const RecordedContribution& c) {
                           return c.source.weight > 0 ? c.radiance / c.source.weight : BLACK;
                         });
        weights.at(i, j)[0] += filterWeights(record);
      });
  Film splatted(crop, classes.layerCount());
  if (scene.camera().isConnectable()) // else no strategy has t = 1
    render(scene, lightPaths, classes, settings, splatted, stop, nullptr, nullptr);
  for (size_t i = 0; i < out.size(); ++i) {
    for (int y = 0; y < crop.height(); ++y)
      for (int x = 0; x < crop.width(); ++x)
        if (const float sum = weights.at(x, y)[0]; sum != 0)
          for (Image* image : {&weighted[i], &unweighted[i]}) divide(*image, x, y, sum);
    const bool isSplat = out[i].cameraVertices == 1;
    const auto layer = size_t(out[i].lightVertices - SHORTEST); // t = 1: s is the number of edges
    out[i].weighted = isSplat && film.splats() ? splatsOf(film, layer) : std::move(weighted[i]);
    out[i].unweighted = isSplat && splatted.splats() ? splatsOf(splatted, layer) : std::move(unweighted[i]);
  }
  return out;
}

std::vector<FigurePanel> pyramidPanels(const std::vector<StrategyPictures>& strategies, bool weighted) {
  std::vector<FigurePanel> panels;
  const auto edgesOf = [](const StrategyPictures& p) { return p.lightVertices + p.cameraVertices - 1; };
  const int longest = edgesOf(strategies.back());
  for (const StrategyPictures& p : strategies) {
    Image sum = p.weighted;
    std::fill(sum.pixels.begin(), sum.pixels.end(), 0.0f);
    for (const StrategyPictures& other : strategies)
      if (edgesOf(other) == edgesOf(p))
        for (size_t i = 0; i < sum.pixels.size(); ++i) sum.pixels[i] += other.weighted.pixels[i];
    panels.push_back({weighted ? p.weighted : p.unweighted,
                      "s=" + std::to_string(p.lightVertices) + " t=" + std::to_string(p.cameraVertices),
                      edgesOf(p) - SHORTEST,
                      static_cast<float>(p.lightVertices) + static_cast<float>(longest - edgesOf(p)) / 2,
                      automaticExposure(sum)});
  }
  return panels;
}

} // namespace recurse
