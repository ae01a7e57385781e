/** @file
 * Displacement: triangle meshes divided finely and moved along their normals by a texture.
 */
#pragma once

#include <memory>
#include <vector>

#include "recurse/model/mesh/triangleMesh.h"

namespace recurse {

/** How finely a surface is to be divided where. */
class Dicing {
 public:
  virtual ~Dicing() = default;
  /** The greatest length that an edge between two points of the shape's space may have. */
  virtual double edgeLength(const Vec3d& a, const Vec3d& b) const = 0;
};

/** The parameters of a shape that can be displaced. */
std::vector<ParameterSpec> withDisplacement(std::vector<ParameterSpec> own);

/**
 * The mesh, displaced where the parameters say so: edges are halved until they are short enough before and
 * after the displacement. Triangles that share an edge share its halves, so that no gaps open. The normals
 * are those of the displaced surface. Throws Error as TriangleMesh does.
 */
std::unique_ptr<TriangleMesh> makeDisplacedMesh(MeshData mesh, const Parameters& p,
                                                const ShapeContext& context);

} // namespace recurse
