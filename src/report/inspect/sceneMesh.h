/** @file
 * A scene as triangles to look at: shapes and their instances, diced and simplified.
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
  std::vector<uint16_t> objects;  ///< of each triangle, in `names`
  std::vector<std::string> names; ///< of objects
  size_t before = 0;              ///< triangles before the mesh was simplified
  /** Shapes that have no faces, such as curves: boxes around them. */
  std::vector<Bounds3f> boxes;

  size_t triangles() const { return objects.size(); }
};

/** A scene in at most `limit` triangles: vertices are brought together on a grid that is coarser the more
 * there are. */
SceneMesh meshOf(const Scene& scene, size_t limit);

} // namespace recurse
