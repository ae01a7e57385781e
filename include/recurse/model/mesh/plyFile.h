/** @file
 * Triangle meshes from PLY files (Turk, "The PLY Polygon File Format", 1994): text and both binary kinds,
 * plain or compressed with gzip.
 */
#pragma once

#include "recurse/core/io/fileReference.h"
#include "recurse/model/mesh/triangleMesh.h"

namespace recurse {

struct PlyFile {
  MeshData mesh;           ///< polygons are fans of triangles around their first vertex
  uint64_t badNormals = 0; ///< normals that are not finite; they are zero in the mesh
  /** Vertices with a position or texture coordinate that is not finite. No face uses them, and the mesh has
   * finite values in their place. */
  size_t brokenVertices = 0;

  /** Calls warn(text) for each kind of discarded data. */
  template <class Warn> void forWarnings(const Warn& warn) const {
    if (badNormals > 0)
      warn(std::to_string(badNormals) +
           " vertices have normals that are not finite; faces are shaded without them");
    if (brokenVertices > 0)
      warn(std::to_string(brokenVertices) + " vertices are not finite; no face uses them");
  }
};

/** Reads a mesh. Throws Error with the location of the fault, a line, or a byte of a binary file; also where
 * a face uses a vertex that is not finite. */
PlyFile readPly(const FileReference& file);

/** The vertices of a PLY file, which need no faces. */
struct PlyPoints {
  std::vector<Vec3d> positions; ///< finite
  std::vector<Vec3d> normals;   ///< one for each position, or none; zero for one that is not finite
  std::vector<double> radii;    ///< one for each position, or none; not checked
};

/** Reads points. Throws Error as readPly() does. */
PlyPoints readPlyPoints(const FileReference& file);

} // namespace recurse
