/** @file
 * Multiple importance sampling of direct light and of all light: both techniques alone and together.
 */
#include <algorithm>

#include "recurse/report/figures/figures.h"
#include "recurse/report/stills/stills.h"
#include "report/figures/techniquePictures.h"

namespace recurse {

std::vector<FigurePanel> misPanels(const Scene& scene, Integrator& path, const RenderSettings& settings,
                                   const std::atomic<bool>& stop) {
  enum Picture { LIGHT_SAMPLES, LIGHT_SAMPLES_WEIGHTED, HITS, HITS_WEIGHTED, BOTH, PICTURES };
  const PixelBounds& crop = scene.film().crop;
  std::vector<Image> pictures(PICTURES, Image(crop.width(), crop.height(), {"R", "G", "B"}));
  Image weights(crop.width(), crop.height(), {"Y"});
  const PathClasses classes;
  Film film(crop, classes.layerCount());
  const auto weighted = [](const PathRecorder&, const RecordedContribution& c) { return c.radiance; };
  const auto alone = [](const PathRecorder&, const RecordedContribution& c) {
    return c.source.weight > 0 ? c.radiance / c.source.weight : BLACK;
  };
  visitRecords(scene, path, classes, settings, film, stop, [&](int x, int y, const PathRecorder& record) {
    const int i = x - crop.x0, j = y - crop.y0;
    const auto add = [&](Picture picture, const auto& isIncluded, const auto& value) {
      const auto which = [&](const PathRecorder&, const RecordedContribution& c) {
        return isIncluded(c.source) ? int(picture) : -1;
      };
      addContributions(scene.film(), record, i, j, pictures, which, value);
    };
    const auto isHit = [](const RecordedSource& s) { return s.technique == PathTechnique::HIT; };
    const auto isLightSample = [](const RecordedSource& s) {
      return s.technique == PathTechnique::LIGHT_SAMPLE;
    };
    // Light that only one technique can find belongs to every picture of a technique alone.
    const auto hasNoOther = [](const RecordedSource& s) { return !(s.otherPdf > 0); };
    add(
        LIGHT_SAMPLES, [&](const auto& s) { return isLightSample(s) || hasNoOther(s); }, alone);
    add(
        HITS, [&](const auto& s) { return isHit(s) || hasNoOther(s); }, alone);
    add(LIGHT_SAMPLES_WEIGHTED, isLightSample, weighted);
    add(HITS_WEIGHTED, isHit, weighted);
    add(
        BOTH, [](const auto&) { return true; }, weighted);
    weights.at(i, j)[0] += filterWeights(record);
  });
  for (Image& picture : pictures)
    for (size_t i = 0; i < picture.pixels.size(); ++i)
      if (const float sum = weights.pixels[i / 3]; sum != 0) picture.pixels[i] /= sum;
  const float exposure = automaticExposure(pictures[BOTH]);
  std::vector<FigurePanel> panels;
  const auto add = [&](Picture picture, const char* name, int row, float column) {
    panels.push_back({std::move(pictures[picture]), name, row, column, exposure});
  };
  add(LIGHT_SAMPLES, "light samples", 0, 0);
  add(HITS, "BSDF samples", 0, 1);
  add(LIGHT_SAMPLES_WEIGHTED, "lights, weighted", 1, 0);
  add(HITS_WEIGHTED, "BSDF, weighted", 1, 1);
  add(BOTH, "both, weighted", 1, 2);
  return panels;
}

} // namespace recurse
