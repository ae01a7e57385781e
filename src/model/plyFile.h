/** @file
 * Triangle meshes from PLY files.
 */
#pragma once

#include "recurse/core/fileReference.h"
#include "recurse/model/triangleMesh.h"

namespace recurse {

struct PlyMesh {
  MeshData mesh;
  uint64_t normalsLeftOut = 0; ///< that are not finite
  size_t brokenVertices = 0;   ///< that are not finite, and no face uses
};

/** Reads a file, text or binary, in one pass, so that a large mesh is in memory once. */
PlyMesh readPlyMesh(const FileReference& file);

} // namespace recurse
