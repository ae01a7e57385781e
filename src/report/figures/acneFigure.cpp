/** @file
 * Shadow acne and light leaks by the offset of shadow rays.
 */
#include <algorithm>
#include <cmath>

#include "recurse/core/io/text.h"
#include "recurse/report/figures/figures.h"
#include "recurse/report/stills/stills.h"
#include "report/figures/visiblePoints.h"

namespace recurse {

namespace {

/** Shadow rays of one row of the picture by one offset. */
struct OffsetCounts {
  uint64_t rays = 0, acne = 0, leaks = 0;
  void add(const OffsetCounts& o) {
    rays += o.rays;
    acne += o.acne;
    leaks += o.leaks;
  }
};

/** Origin of a ray at a fixed distance from the surface, on the side of its direction. */
Vec3f originAt(const SurfacePoint& point, const Vec3f& direction, float offset) {
  return point.position + point.normalTowards(direction) * offset;
}

} // namespace

std::vector<AcnePicture> acnePictures(const Scene& scene, const std::vector<float>& offsets, int64_t samples,
                                      uint64_t seed, const std::atomic<bool>& stop) {
  requireVisiblePoints(scene);
  const PixelBounds& crop = scene.film().crop;
  const size_t rule = offsets.size(); // index of the program's rule
  std::vector<AcnePicture> out(rule + 1);
  for (size_t k = 0; k <= rule; ++k) {
    out[k].image = Image(crop.width(), crop.height(), {"R", "G", "B"});
    out[k].offset = k < rule ? offsets[k] : -1;
  }
  std::vector<std::vector<OffsetCounts>> rows(size_t(crop.height()), std::vector<OffsetCounts>(rule + 1));
  const auto addRay = [&](size_t p, const SurfacePoint& from, const ViewedLight& sample) {
    const auto add = [&](size_t k, bool blocked, bool blockedByRule) {
      OffsetCounts& counts = rows[p / size_t(crop.width())][k];
      ++counts.rays;
      counts.acne += blocked && !blockedByRule;
      counts.leaks += !blocked && blockedByRule;
      if (blocked) return;
      for (int c = 0; c < 3; ++c)
        out[k].image.pixels[3 * p + size_t(c)] +=
            sample.contribution[c] / (sample.density * static_cast<float>(samples));
    };
    const bool blockedByRule = isBlocked(scene, from, from.rayOrigin(sample.light.direction), sample.light);
    add(rule, blockedByRule, blockedByRule);
    for (size_t k = 0; k < rule; ++k)
      add(k, isBlocked(scene, from, originAt(from, sample.light.direction, offsets[k]), sample.light),
          blockedByRule);
  };
  visitViews(scene, stop, [&](size_t p, const PixelView& view) {
    for (AcnePicture& picture : out)
      for (int c = 0; c < 3; ++c) picture.image.pixels[3 * p + size_t(c)] = view.emission[c];
    for (int64_t i = 0; i < samples && !stop; ++i) {
      Sampler sampler(seed, p, static_cast<uint32_t>(i));
      for (const ViewedPoint& point : view.points)
        if (const auto sample =
                sampleLight(scene, point, ScatteringPoint(*point.bsdf, point.hit.point), sampler))
          addRay(p, point.hit.point, *sample);
    }
  });
  for (size_t k = 0; k <= rule; ++k) {
    OffsetCounts sum;
    for (const auto& row : rows) sum.add(row[k]);
    if (sum.rays == 0) continue;
    out[k].acne = double(sum.acne) / double(sum.rays);
    out[k].leaks = double(sum.leaks) / double(sum.rays);
  }
  return out;
}

std::vector<float> defaultOffsets(const Scene& scene) {
  std::vector<float> out;
  for (const float part : {0.0f, 1e-7f, 1e-6f, 1e-4f, 1e-2f, 0.1f})
    out.push_back(part * scene.bounds().radius);
  return out;
}

std::vector<FigurePanel> acnePanels(std::vector<AcnePicture> pictures) {
  constexpr size_t COLUMNS = 4;
  const float exposure = automaticExposure(pictures.back().image);
  std::vector<FigurePanel> panels;
  for (size_t k = 0; k < pictures.size(); ++k) {
    AcnePicture& p = pictures[k];
    const std::string name = p.offset < 0 ? "by the error of the position"
                                          : formatted("%.2g: %.1f %% acne, %.1f %% leaks", double(p.offset),
                                                      100 * p.acne, 100 * p.leaks);
    panels.push_back(
        {std::move(p.image), name, static_cast<int>(k / COLUMNS), static_cast<float>(k % COLUMNS), exposure});
  }
  return panels;
}

} // namespace recurse
