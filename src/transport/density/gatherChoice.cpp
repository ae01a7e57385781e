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
constexpr Nearest ONE_MAP{50, 100, 16}, PROGRESSIVE{8, 40, 8};

double quantile(std::vector<double>& values, double p) {
  const auto i = static_cast<std::ptrdiff_t>(p * double(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + i, values.end());
  return values[size_t(i)];
}

/** Photon counts, radii and pixel widths of density estimates at visible points. */
struct PhotonsAround {
  std::vector<double> radii;  ///< radius of the k nearest photons, where so many were found [scene units]
  std::vector<double> counts; ///< photons found
  std::vector<double> widths; ///< pixel widths [scene units]
};

/** Searches by `search` around visible points. */
PhotonsAround searchAround(std::span<const VisiblePoint> seen, const PhotonMap& map,
                           const GatherSettings& search) {
  PhotonsAround around;
  PhotonScratch scratch;
  for (const VisiblePoint& visible : seen) {
    around.widths.push_back(double(visible.footprint));
    const GatherRegion region{visible.point.position, visible.point.geometricNormal, search.radius,
                              search.flatness, true};
    int count = 0;
    if (search.nearest > 0) {
      const NearestPhotons n = map.nearest(region, search.nearest, scratch);
      count = n.count;
      if (count == search.nearest && n.radius2 > 0) around.radii.push_back(double(std::sqrt(n.radius2)));
    } else {
      map.visitWithin(region, [&](const PhotonBlock& b) { count += std::popcount(b.mask); });
    }
    around.counts.push_back(count);
  }
  return around;
}

/** Chooses the number of nearest photons in `range` that brings the median radius closest to its width, and
 * scales the radii to it. */
int chooseNearest(const Nearest& range, PhotonsAround& around) {
  if (around.radii.empty()) return range.least;
  const double widening = range.width * quantile(around.widths, 0.5) / quantile(around.radii, 0.5);
  const int nearest = static_cast<int>(
      std::clamp(range.least * widening * widening, double(range.least), double(range.most)));
  for (double& r : around.radii) r *= std::sqrt(double(nearest) / range.least);
  return nearest;
}

/** Warns of artifacts of a single map in a scene of radius `sceneRadius`. */
void warnOfArtifacts(double photons, double radius, double sceneRadius, std::vector<std::string>& warnings) {
  if (photons < 25)
    warnings.push_back(formatted(
        "the picture will show blotches: a density estimate uses %.0f photons (median). Emit more "
        "photons (--photons), increase the radius (--radius), or omit \"passes\": several passes aim "
        "photons at what the camera sees",
        photons));
  if (radius > 0.05 * sceneRadius)
    warnings.push_back(
        formatted("the picture will be blurred: density estimates average over discs of radius %.3g (median) "
                  "in a scene of diameter %.3g. Emit more photons (--photons) or decrease the radius "
                  "(--radius, --gather-photons)",
                  radius, 2 * sceneRadius));
}

} // namespace

GatherChoice chooseGather(const Scene& scene, const PhotonMap& map, std::span<const VisiblePoint> seen,
                          const GatherSettings& requested, bool progressive, bool allLight,
                          ForwardStatistics& statistics) {
  GatherChoice choice{requested};
  GatherSettings& search = choice.settings;
  const Nearest range = progressive ? PROGRESSIVE : ONE_MAP;
  const bool anyRadius = requested.radius == 0;
  if (anyRadius) search.radius = 2 * scene.bounds().radius;
  if (requested.nearest == 0 && anyRadius) search.nearest = range.least;
  if (seen.empty()) {
    statistics.notes.push_back(
        "the camera sees no surface that uses photons: mirrors, glass and background only");
    return choice;
  }
  PhotonsAround around = searchAround(seen, map, search);
  if (requested.nearest == 0 && anyRadius) search.nearest = chooseNearest(range, around);
  const double sceneRadius = double(scene.bounds().radius);
  const double typical = around.radii.empty() ? double(requested.radius) : quantile(around.radii, 0.5);
  if (anyRadius)
    search.radius =
        static_cast<float>(around.radii.empty() ? 0.1 * sceneRadius : 2 * quantile(around.radii, 0.95));
  if (!around.radii.empty())
    statistics.notes.push_back(formatted("density estimate: %s%d nearest photons, median radius %.3g, "
                                         "maximum radius %.3g; diameter of the scene %.3g",
                                         progressive ? "at first " : "", search.nearest, typical,
                                         double(search.radius), 2 * sceneRadius));
  else if (search.nearest == 0)
    statistics.notes.push_back(formatted(
        "density estimate: all photons within radius %.3g, median number %.0f; diameter of the scene %.3g",
        typical, quantile(around.counts, 0.5), 2 * sceneRadius));
  choice.typicalRadius = static_cast<float>(typical);
  if (map.empty() && allLight)
    statistics.warnings.push_back("no photon was stored: the picture shows emitted light only. Check that "
                                  "the lights illuminate a surface");
  else if (map.empty())
    statistics.notes.push_back("no photon of indirect light was stored on a surface");
  else if (!progressive) // more passes reduce both artifacts
    warnOfArtifacts(quantile(around.counts, 0.5), typical, sceneRadius, statistics.warnings);
  return choice;
}

} // namespace recurse
