/** @file
 * Choice of radius and number of photons from the photons' density and the pixels' width.
 */
#include "transport/density/gatherChoice.h"
#include "transport/photonmap/photonMapQuery.h"

#include <algorithm>
#include <bit>

#include "recurse/core/io/text.h"

namespace recurse {

namespace {

/** Range of photons for a search with a radius of `width` pixels, if the photon density allows. Fewer photons
 * are noisy; a wider support is blurred, and takes many passes to sharpen. */
struct Nearest {
  int least, most;
  double width;
};
constexpr Nearest ONE_MAP{50, 100, 16}, PROGRESSIVE{8, 40, 8}, PROGRESSIVE_FINE{8, 40, 4};

} // namespace

GatherChoice chooseGather(const Scene& scene, const PhotonMap& map, std::span<const VisiblePoint> seen,
                          const GatherSettings& requested, bool progressive, bool allLight,
                          LightDetail detail, ForwardStatistics& statistics) {
  GatherChoice choice{requested};
  GatherSettings& search = choice.settings;
  const Nearest range = !progressive ? ONE_MAP : detail == LightDetail::FINE ? PROGRESSIVE_FINE : PROGRESSIVE;
  const bool anyRadius = requested.radius == 0;
  if (requested.nearest == 0 && anyRadius) search.nearest = range.least;
  if (seen.empty()) {
    statistics.notes.push_back("the camera sees no diffuse surface: photons are not used");
    if (anyRadius) search.radius = 2 * scene.bounds().radius;
    return choice;
  }
  std::vector<double> radii, found, widths;
  PhotonScratch scratch;
  for (const VisiblePoint& visible : seen) {
    widths.push_back(double(visible.footprint));
    GatherRegion region;
    region.center = visible.point.position;
    region.normal = visible.point.geometricNormal;
    region.bothSides = true;
    region.flatness = search.flatness;
    region.radius = anyRadius ? 2 * scene.bounds().radius : search.radius;
    if (search.nearest > 0) {
      const NearestPhotons n = map.nearest(region, search.nearest, scratch);
      found.push_back(n.count);
      if (n.count == search.nearest && n.radius2 > 0) radii.push_back(double(std::sqrt(n.radius2)));
    } else {
      int n = 0;
      map.visitWithin(region, [&](const PhotonBlock& b) { n += std::popcount(b.mask); });
      found.push_back(n);
    }
  }
  const auto quantile = [](std::vector<double>& v, double p) {
    const auto i = static_cast<std::ptrdiff_t>(p * double(v.size() - 1));
    std::nth_element(v.begin(), v.begin() + i, v.end());
    return v[size_t(i)];
  };
  if (search.nearest > 0 && requested.nearest == 0 && !radii.empty()) {
    const double widening = range.width * quantile(widths, 0.5) / quantile(radii, 0.5);
    search.nearest = static_cast<int>(
        std::clamp(range.least * widening * widening, double(range.least), double(range.most)));
    for (double& r : radii) r *= std::sqrt(double(search.nearest) / range.least);
  }
  const double across = double(scene.bounds().radius);
  double typical = double(requested.radius);
  if (search.nearest > 0) {
    if (!radii.empty()) {
      typical = quantile(radii, 0.5);
      if (anyRadius) search.radius = static_cast<float>(2 * quantile(radii, 0.95));
      statistics.notes.push_back(formatted("density estimate: %s%d nearest photons, median radius %.3g, "
                                           "maximum radius %.3g; diameter of the scene %.3g",
                                           progressive ? "at first " : "", search.nearest, typical,
                                           double(search.radius), 2 * across));
    } else if (anyRadius) {
      search.radius = static_cast<float>(0.1 * across);
    }
  } else {
    statistics.notes.push_back(formatted(
        "density estimate: all photons within radius %.3g, median number %.0f; diameter of the scene %.3g",
        typical, quantile(found, 0.5), 2 * across));
  }
  choice.typicalRadius = static_cast<float>(typical);
  if (map.empty()) {
    if (allLight)
      statistics.warnings.push_back("no photon was stored: the picture shows emitted light only. Check that "
                                    "the lights illuminate a surface");
    else
      statistics.notes.push_back("no photon was stored: the scene has direct light only, or none");
    return choice;
  }
  if (progressive) return choice; // more passes reduce both artifacts
  if (const double typicalFound = quantile(found, 0.5); typicalFound < 25)
    statistics.warnings.push_back(
        formatted("the picture will show blotches: a density estimate uses %.0f photons (median). Emit more "
                  "photons (--photons) or increase the radius (--radius)",
                  typicalFound));
  if (typical > 0.05 * across)
    statistics.warnings.push_back(
        formatted("the picture will be blurred: density estimates average over discs of radius %.3g (median) "
                  "in a scene of diameter %.3g. Emit more photons (--photons) or decrease the radius "
                  "(--radius, --gather-photons)",
                  typical, 2 * across));
  return choice;
}

} // namespace recurse
