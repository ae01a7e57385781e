/** @file
 * Lists of light paths.
 */
#include "recurse/transport/lightSubpaths.h"

namespace recurse {

void LightSubpaths::clear() {
  paths.clear();
  vertices.clear();
}

void LightSubpaths::append(const LightSubpaths& more) {
  const size_t before = vertices.size();
  vertices.insert(vertices.end(), more.vertices.begin(), more.vertices.end());
  for (StoredPath path : more.paths) {
    path.first += before;
    paths.push_back(path);
  }
}

size_t LightSubpaths::memoryBytes() const {
  return paths.capacity() * sizeof(StoredPath) + vertices.capacity() * sizeof(StoredVertex);
}

void LightSubpaths::appendDensities(const StoredPath& path, uint32_t count, uint32_t most,
                                    std::vector<WeightedVertex>& x) const {
  for (uint32_t i = count; i > 0; --i, --most) {
    if (most == 0) return;
    const StoredVertex& v = vertices[path.first + i - 1];
    x.push_back({v.fromCamera, v.fromLight, v.delta});
  }
  if (most > 0) x.push_back({path.fromCamera, path.end.pdf});
}

} // namespace recurse
