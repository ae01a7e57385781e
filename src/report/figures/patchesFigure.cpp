/** @file
 * Patches of a radiosity solution beside the smoothed picture.
 */
#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/report/figures/figures.h"
#include "recurse/report/stills/stills.h"
#include "report/figures/visiblePoints.h"

namespace recurse {

namespace {

/** Light that radiosity distributes between patches, and all of it. */
const std::vector<PathClass> PATCHES_CLASSES = {{"indirect", "LDD+E"}, {"all", "all"}};
enum PatchesLayer : size_t { INDIRECT, ALL };

constexpr uint32_t NO_PATCH = ~0u;

/** Patch and side in the middle of a pixel. */
struct SeenPatch {
  uint32_t patch = NO_PATCH;
  size_t side = 0;
  bool operator==(const SeenPatch&) const = default;
};

std::vector<SeenPatch> seenPatches(const Scene& scene, const Integrator& radiosity,
                                   const std::atomic<bool>& stop) {
  std::vector<SeenPatch> seen(scene.film().crop.area());
  visitMiddleRays(scene, stop, [&](size_t pixel, const CameraRay& ray) {
    const std::optional<Hit> hit = followRay(scene, ray, [](const Hit*) {});
    if (!hit) return;
    if (const auto patch = radiosity.patchAt(*hit))
      seen[pixel] = {*patch, glm::dot(ray.direction, hit->point.geometricNormal) > 0};
  });
  return seen;
}

/** Whether a line of the mesh runs between a pixel and the one to the right or below. */
bool isOnMesh(const std::vector<SeenPatch>& seen, const PixelBounds& crop, size_t pixel) {
  const auto width = size_t(crop.width());
  if (seen[pixel].patch == NO_PATCH) return false;
  const auto differs = [&](size_t other) {
    return seen[other].patch != NO_PATCH && !(seen[other] == seen[pixel]);
  };
  return ((pixel + 1) % width != 0 && differs(pixel + 1)) ||
         (pixel + width < seen.size() && differs(pixel + width));
}

Image patchPicture(const PixelBounds& crop, const std::vector<SeenPatch>& seen,
                   const std::vector<RadiosityPatch>& patches) {
  constexpr float LINE = 0.4f; // brightness of mesh lines over that of the patch
  Image image(crop.width(), crop.height(), {"R", "G", "B"});
  for (size_t p = 0; p < seen.size(); ++p) {
    if (seen[p].patch == NO_PATCH) continue;
    const Rgb radiance = patches[seen[p].patch].radiosity(seen[p].side) * INV_PI;
    for (int c = 0; c < 3; ++c)
      image.pixels[3 * p + size_t(c)] = radiance[c] * (isOnMesh(seen, crop, p) ? LINE : 1.0f);
  }
  return image;
}

Image layerPicture(const Film& film, size_t layer) {
  Image image(film.bounds().width(), film.bounds().height(), {"R", "G", "B"});
  for (size_t p = 0; p < film.bounds().area(); ++p)
    for (int c = 0; c < 3; ++c) image.pixels[3 * p + size_t(c)] = film.value(p, layer)[c];
  return image;
}

} // namespace

std::vector<FigurePanel> patchesPanels(const Scene& scene, Integrator& radiosity,
                                       const RenderSettings& settings, const std::atomic<bool>& stop) {
  const PathClasses classes(PATCHES_CLASSES);
  Film film(scene.film().crop, classes.layerCount());
  render(scene, radiosity, classes, settings, film, stop, nullptr, nullptr);
  if (stop) return {};
  std::vector<RadiosityPatch> patches;
  radiosity.visitPatches([&](const RadiosityPatch& patch) { patches.push_back(patch); });
  if (patches.empty())
    throw Error(
        "the figure needs shapes at rest with one diffuse material, outside of objects, which radiosity "
        "divides into patches; the scene has none");
  const Image indirect = layerPicture(film, INDIRECT), all = layerPicture(film, ALL);
  const float exposure = automaticExposure(indirect);
  const std::vector<SeenPatch> seen = seenPatches(scene, radiosity, stop);
  if (stop) return {};
  const Image byPatch = patchPicture(film.bounds(), seen, patches);
  return {{byPatch, formatted("indirect light of %zu patches", patches.size()), 0, 0, exposure},
          {indirect, "interpolated", 0, 1, exposure},
          {all, "with direct light", 0, 2, automaticExposure(all)}};
}

} // namespace recurse
