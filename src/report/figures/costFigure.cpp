/** @file
 * Cost of pixels in false colours.
 */
#include <algorithm>
#include <cmath>

#include "recurse/core/io/text.h"
#include "recurse/render/recordPixels.h"
#include "recurse/report/figures/figures.h"
#include "report/compare/falseColour.h"

namespace recurse {

namespace {

/** Picture of one quantity per sample. False colours reach from the 1 % to the 99 % quantile. */
FigurePanel costPanel(const PixelBounds& crop, const std::vector<double>& values, const char* unit,
                      int column) {
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const auto quantile = [&](double part) { return sorted[size_t(part * double(sorted.size() - 1))]; };
  const double low = quantile(0.01), high = quantile(0.99);
  FigurePanel panel{Image(crop.width(), crop.height(), {"R", "G", "B"}), "", 0, static_cast<float>(column),
                    0};
  for (size_t i = 0; i < values.size(); ++i) {
    const double t = high > low ? std::clamp((values[i] - low) / (high - low), 0.0, 1.0) : 0;
    const Rgb colour = falseColour(static_cast<float>(t));
    for (size_t c = 0; c < 3; ++c) panel.image.pixels[3 * i + c] = colour[int(c)];
  }
  panel.name = formatted("%.3g to %.3g %s", low, high, unit);
  return panel;
}

} // namespace

int64_t samplesTaken(const Integrator& integrator, const RenderSettings& settings) {
  return std::max<int64_t>(settings.samplesPerPixel,
                           integrator.passes(settings.samplesPerPixel).minSamples());
}

std::vector<FigurePanel> costPanels(const Scene& scene, Integrator& integrator,
                                    const RenderSettings& settings, const std::atomic<bool>& stop) {
  const PixelBounds& crop = scene.film().crop;
  const size_t pixels = crop.area();
  std::vector<double> rays(pixels), photons(pixels), microseconds(pixels);
  const PathClasses classes;
  Film film(crop, classes.layerCount());
  const auto samples = double(samplesTaken(integrator, settings));
  visitCosts(scene, integrator, classes, settings, film, stop,
             [&](int x, int y, const TransportCounts& counts, double seconds) {
               const size_t i = size_t(y - crop.y0) * size_t(crop.width()) + size_t(x - crop.x0);
               rays[i] += double(counts.rays) / samples;
               photons[i] += double(counts.photonsFound) / samples;
               microseconds[i] += 1e6 * seconds / samples;
             });
  std::vector<FigurePanel> panels;
  panels.push_back(costPanel(crop, rays, "rays", 0));
  if (std::any_of(photons.begin(), photons.end(), [](double x) { return x > 0; }))
    panels.push_back(costPanel(crop, photons, "photons", 1));
  panels.push_back(costPanel(crop, microseconds, "us", static_cast<int>(panels.size())));
  return panels;
}

} // namespace recurse
