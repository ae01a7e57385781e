/** @file
 * Subdivision surfaces of Doo and Sabin, "Behaviour of Recursive Division Surfaces near Extraordinary
 * Points" (1978), on polygon meshes with boundaries.
 */
#pragma once

#include "recurse/model/mesh/triangleMesh.h"

namespace recurse {

/** Mesh of polygons, counterclockwise as seen from the outside. */
struct PolygonMesh {
  std::vector<Vec3d> positions;
  std::vector<Vec2d> uvs;         ///< one for each position, or none
  std::vector<uint32_t> starts;   ///< index of each face's first corner, and the number of all corners
  std::vector<uint32_t> vertices; ///< vertex of each corner

  size_t faceCount() const { return starts.size() - 1; }
};

/**
 * One step: each corner of a face becomes a vertex; each face, edge and vertex becomes a face. On the
 * boundary, the surface continues straight to a curve that is Chaikin's of the boundary polygon. Each
 * directed edge must belong to one face at most.
 */
PolygonMesh dooSabinStep(const PolygonMesh& mesh);

/** Triangles whose vertices are points of the limit surface, with its normals, after `levels` steps: the
 * centres of faces and of boundary edges. */
MeshData dooSabinSurface(PolygonMesh mesh, int levels);

} // namespace recurse
