/** @file
 * Triangle meshes: the shape that mesh plug-ins make, and that Embree intersects natively.
 */
#pragma once

#include <atomic>
#include <mutex>
#include <vector>

#include "recurse/model/shape/shape.h"

namespace recurse {

/** Mesh as stored in files, in object space and double precision. */
struct MeshData {
  std::vector<Vec3d> positions;
  /** One for each position, or none; of any length. A zero normal has no weight in the interpolation; a
   * triangle with zero normals only has its own normal. */
  std::vector<Vec3d> normals;
  std::vector<Vec3d> tangents; ///< pbrt's S: one for each position, or none
  std::vector<Vec2d> uvs;      ///< one for each position; none: (0, 0), (1, 0), (1, 1) in each triangle
  /** Indices of positions a, b, c. The normals point outside; without normals (b - a) x (c - a) does. */
  std::vector<glm::uvec3> triangles;
};

class TriangleMesh final : public Shape {
 public:
  /** Applies the transform of the context. Throws Error for indices out of range, non-finite numbers or
   * arrays of wrong length. */
  TriangleMesh(const MeshData& data, const ShapeContext& context);
  /** Consumes the data during construction, so that a large mesh is in memory only once. */
  TriangleMesh(MeshData&& data, const ShapeContext& context);

  const std::vector<Vec3f>& positions() const { return vertices; }
  const std::vector<glm::uvec3>& indices() const { return triangles; }

  uint32_t primitiveCount() const override { return static_cast<uint32_t>(triangles.size()); }
  Bounds3f bounds(uint32_t primitive) const override;
  std::optional<PrimitiveHit> intersect(uint32_t, const Vec3f&, const Vec3f&, float, float) const override;
  SurfacePoint surfaceAt(uint32_t primitive, const HitParameters& parameters) const override;
  SurfacePoint placeAt(uint32_t primitive, const HitParameters& parameters) const override;
  /** Prefetches data of surfaceAt() into the cache: call this first, then prefetchVertices(). */
  void prefetchTriangle(uint32_t primitive) const {
    __builtin_prefetch(&triangles[primitive]);
    __builtin_prefetch(&planes[primitive]);
  }
  void prefetchVertices(uint32_t primitive) const {
    for (int k = 0; k < 3; ++k) __builtin_prefetch(&vertices[triangles[primitive][k]]);
  }
  float area() const override { return totalArea; }
  ShapeSample sampleArea(float pick, const Vec2f& u) const override;
  const TriangleMesh* triangleMesh() const override { return this; }
  std::unique_ptr<Solid> asSolid() const override;
  std::vector<RimPiece> rim() const override;

 private:
  /** Normal by the winding rule, in double precision, not normalised; zero for a degenerate triangle. */
  Vec3d windingNormal(const glm::uvec3& triangle) const;
  void tabulateAreas() const;
  /** Precomputed data of hits: the normal on the outer side by the winding rule, and the distance from the
   * plane within which Embree may report a point [scene units]. */
  struct Plane {
    Vec3f normal;
    float error;
  };
  Plane planeOf(const glm::uvec3& triangle) const;
  template <bool ALL> SurfacePoint pointAt(uint32_t primitive, const Vec2f& parameters) const;

  std::vector<Vec3f> vertices, normals, tangents;
  std::vector<Vec2f> uvs;
  std::vector<glm::uvec3> triangles;
  std::vector<Plane> planes;
  float totalArea = 0;
  bool flipped = false; ///< true: the normal by the winding rule points inside

  // The table is made at first use, since only emitting meshes are sampled.
  mutable std::once_flag once;
  mutable std::atomic<bool> tabulated = false; ///< cheaper to test than the flag
  mutable std::vector<double> cumulativeArea;  ///< sums of areas over triangles [0, i]
};

} // namespace recurse
