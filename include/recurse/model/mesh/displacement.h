/** @file
 * Displacement: triangle meshes that are diced finely and moved along their normals by a texture.
 */
#pragma once

#include <memory>
#include <vector>

#include "recurse/model/mesh/triangleMesh.h"

namespace recurse {

/** Resolution at which a surface is diced. */
class Dicing {
 public:
  virtual ~Dicing() = default;
  /** Maximum length of an edge from a to b, in the space of the scene (or of the shape's instance). */
  virtual double edgeLength(const Vec3d& a, const Vec3d& b) const = 0;
};

/** Parameters of a shape that can be displaced: `own` and the parameters of displacement. */
std::vector<ParameterSpec> withDisplacement(std::vector<ParameterSpec> own);

/**
 * The mesh, displaced if the parameters say so: edges are halved until they are no longer than the limit
 * before and after displacement, or no longer than half of it before, so that steep displacement leaves
 * longer edges. A warning reports a division that ends at the maximum of 20 million triangles. Triangles
 * split common edges at the same points, so that no cracks appear. Normals are recomputed from the displaced
 * surface. Throws Error as TriangleMesh does, for a displacement that is not finite, for edgelength without
 * displacement, for displacement with neither edgelength nor `context.dicing`, and for too much memory or
 * work.
 */
std::unique_ptr<TriangleMesh> makeDisplacedMesh(MeshData mesh, const Parameters& p,
                                                const ShapeContext& context);

} // namespace recurse
