/** @file
 * Storage of light paths.
 */
#include "integrators/bidirectional/lightSubpaths.h"

namespace recurse {

void LightSubpaths::clear() {
  paths.clear();
  vertices.clear();
  lengths.clear();
}

void LightSubpaths::append(const LightSubpaths& more) {
  const size_t before = vertices.size();
  vertices.insert(vertices.end(), more.vertices.begin(), more.vertices.end());
  lengths.insert(lengths.end(), more.lengths.begin(), more.lengths.end());
  for (StoredPath path : more.paths) {
    path.first += before;
    paths.push_back(path);
  }
}

size_t LightSubpaths::memoryBytes() const {
  return paths.capacity() * sizeof(StoredPath) + vertices.capacity() * sizeof(StoredVertex) +
         lengths.capacity() * sizeof(float);
}

ShadowRayStart LightSubpaths::shadowRayStart(const StoredPath& path, uint32_t count,
                                             const Vec3f& towardsCamera) const {
  uint32_t i = 1;
  while (i < count && vertex(path, i).straight) ++i;
  const StoredVertex& y = vertex(path, i);
  ShadowRayStart start;
  if (i < count && y.delta) return start;
  start.point = &y.point;
  start.towardsCamera = i < count ? -vertex(path, i + 1).wi : towardsCamera;
  start.panes = i - 1;
  if (start.panes > 0) {
    start.firstPane = &vertex(path, i - 1).point;
    start.lastPane = &vertex(path, 1).point;
  }
  return start;
}

void LightSubpaths::appendDensities(const StoredPath& path, uint32_t count,
                                    std::vector<WeightedVertex>& x) const {
  for (uint32_t i = count; i > 0; --i) {
    const StoredVertex& v = vertices[path.first + i - 1];
    x.push_back({v.fromCamera, v.fromLight, v.delta});
  }
  x.push_back({path.fromCamera, path.end.pdf});
}

} // namespace recurse
