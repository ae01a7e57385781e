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
  std::vector<uint8_t> specular;  ///< of each triangle: 1: mirror or clear glass, which stores no photons
  std::vector<std::string> names; ///< names of objects
  size_t before = 0;              ///< triangles before the mesh was simplified
  size_t sampledShapes = 0;       ///< shapes without faces, diced by rays through a grid
  size_t curves = 0;              ///< segments of curves, of which `shownCurves` are in the mesh
  size_t shownCurves = 0;         ///< the wider, the fewer they are

  size_t triangles() const { return objects.size(); }
};

/** Scene in at most `limit` triangles. Vertices are merged on a grid whose cells grow with the distance from
 * the camera, and outside of its view; they are as small as the limit allows. */
SceneMesh meshOf(const Scene& scene, size_t limit);

} // namespace recurse
