/** @file
 * Triangle meshes: the shape that the mesh plug-ins make, and that Embree intersects by itself.
 */
#pragma once

#include <vector>

#include "recurse/model/shape.h"

namespace recurse {

/** A mesh as files have it, in object space and double precision. */
struct MeshData {
  std::vector<Vec3d> positions;
  std::vector<Vec3d> normals;        ///< one for each position, or none; need not be unit
  std::vector<Vec2d> uvs;            ///< one for each position, or none
  std::vector<glm::uvec3> triangles; ///< indices of positions
};

class TriangleMesh final : public Shape {
 public:
  /** Bakes the transform. Throws Error for indices out of range, non-finite numbers or arrays of wrong
   * length. */
  TriangleMesh(const MeshData& data, const ShapeContext& context);

  const std::vector<Vec3f>& positions() const { return vertices; }
  const std::vector<glm::uvec3>& indices() const { return triangles; }

  uint32_t primitiveCount() const override { return static_cast<uint32_t>(triangles.size()); }
  Bounds3f bounds(uint32_t primitive) const override;
  std::optional<PrimitiveHit> intersect(uint32_t, const Vec3f&, const Vec3f&, float, float) const override;
  SurfacePoint surfaceAt(uint32_t primitive, const Vec2f& parameters) const override;
  float area() const override { return totalArea; }
  ShapeSample sampleArea(float pick, const Vec2f& u) const override;
  const TriangleMesh* triangleMesh() const override { return this; }

 private:
  std::vector<Vec3f> vertices, normals;
  std::vector<Vec2f> uvs;
  std::vector<glm::uvec3> triangles;
  std::vector<float> cumulativeArea; ///< of triangles [0, i], over the total; filled for sampling
  float totalArea = 0;
  bool flipped = false; ///< the winding rule's normal points inside
};

} // namespace recurse
