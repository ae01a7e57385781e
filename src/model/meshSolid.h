/** @file
 * Closed triangle meshes as solids.
 */
#pragma once

#include "recurse/model/triangleMesh.h"

namespace recurse {

/** Throws Error that names an edge where the mesh is open or its faces are turned against each other. */
std::unique_ptr<Solid> makeMeshSolid(const TriangleMesh& mesh);

/** The edges of one triangle only, where vertices at the same place are one. */
std::vector<RimPiece> rimOf(const TriangleMesh& mesh);

} // namespace recurse
