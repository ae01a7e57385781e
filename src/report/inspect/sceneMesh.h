/** @file
 * Scene as triangles for display: shapes and their instances, tessellated and simplified.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/model/scene/scene.h"

namespace recurse {

/** Triangles of a scene, relative to Scene::origin() [scene units]. */
struct SceneMesh {
  std::vector<float> positions;   ///< nine for each triangle
  std::vector<uint8_t> colours;   ///< three for each triangle: albedo of its middle, as sRGB
  std::vector<uint16_t> objects;  ///< object of each triangle, an index of `names`
  std::vector<std::string> names; ///< names of objects
  size_t before = 0;              ///< triangles before the mesh was simplified
  /** Shapes that have no faces, such as curves: boxes around them. */
  std::vector<Bounds3f> boxes;

  size_t triangles() const { return objects.size(); }
};

/** Scene in at most `limit` triangles: vertices are merged on a grid, which is coarser the more triangles
 * there are. */
SceneMesh meshOf(const Scene& scene, size_t limit);

} // namespace recurse
