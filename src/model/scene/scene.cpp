/** @file
 * Default batch queries, one ray at a time.
 */
#include "recurse/model/scene/scene.h"

namespace recurse {

void Scene::intersectBatch(std::span<const Ray> rays, Coherence, std::span<Hit> hits) const {
  for (size_t i = 0; i < rays.size(); ++i)
    if (!intersect(rays[i], hits[i])) hits[i].t = INFINITE;
}

void Scene::occludedBatch(std::span<const Ray> rays, std::span<uint8_t> blocked) const {
  for (size_t i = 0; i < rays.size(); ++i) blocked[i] = occluded(rays[i]);
}

} // namespace recurse
