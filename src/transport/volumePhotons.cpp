/** @file
 * The tree of boxes over volume photons.
 */
#include "recurse/transport/volumePhotons.h"

#include <algorithm>

#include "recurse/core/parallel.h"

namespace recurse {

namespace {

/** The radius at which about PHOTONS of so many in the box are within a cube of that side. A box that is
 * flat, as that of a beam's cross-section, counts as a tenth as thick as it is wide. */
float radiusIn(const Bounds3f& box, size_t count) {
  constexpr float PHOTONS = 2, FLAT = 0.1f;
  const Vec3f extent = box.diagonal();
  const float least = FLAT * std::max(extent.x, std::max(extent.y, extent.z));
  const Vec3f e = glm::max(extent, Vec3f(least));
  return std::cbrt(PHOTONS / static_cast<float>(count)) * std::cbrt(e.x) * std::cbrt(e.y) * std::cbrt(e.z);
}

} // namespace

void VolumePhotonMap::build(std::vector<VolumePhoton> all, float scale, float widest) {
  photons = std::move(all);
  levels = 0;
  while (levels < MAX_LEVELS && photons.size() >> levels > LEAF) ++levels;
  for (uint32_t level = 0; level < levels; ++level)
    parallelFor(size_t(1) << level, [&](size_t i) {
      const auto at = [&](uint32_t l, size_t index) {
        return photons.begin() + static_cast<std::ptrdiff_t>(firstOf(l, index));
      };
      const auto first = at(level, i), end = at(level, i + 1);
      Bounds3f box;
      for (auto p = first; p != end; ++p) box.add(p->position);
      const int axis = widestAxis(box.diagonal());
      std::nth_element(first, at(level + 1, 2 * i + 1), end,
                       [axis](const VolumePhoton& a, const VolumePhoton& b) {
                         return a.position[axis] < b.position[axis];
                       });
    });
  radii.resize(photons.size());
  const uint32_t parts = levels - std::min(levels, LEVELS_OF_PART);
  parallelFor(size_t(1) << parts, [&](size_t i) {
    const size_t first = firstOf(parts, i), end = firstOf(parts, i + 1);
    Bounds3f box;
    for (size_t k = first; k < end; ++k) box.add(photons[k].position);
    float radius = end > first ? radiusIn(box, end - first) : 0;
    if (!(radius > 0)) radius = widest; // all in one point
    std::fill(radii.begin() + static_cast<std::ptrdiff_t>(first),
              radii.begin() + static_cast<std::ptrdiff_t>(end), scale * std::min(radius, widest));
  });
  boxes.assign((size_t(2) << levels) - 1, Bounds3f());
  const size_t leaves = (size_t(1) << levels) - 1;
  parallelFor(size_t(1) << levels, [&](size_t i) {
    for (size_t k = firstOf(levels, i); k < firstOf(levels, i + 1); ++k) {
      boxes[leaves + i].add(photons[k].position - radii[k]);
      boxes[leaves + i].add(photons[k].position + radii[k]);
    }
  });
  for (size_t i = leaves; i-- > 0;) {
    boxes[i].add(boxes[2 * i + 1]);
    boxes[i].add(boxes[2 * i + 2]);
  }
}

} // namespace recurse
