/** @file
 * Steps and limits of √3 subdivision.
 */
#include "shapes/subdivision/sqrt3.h"

#include "recurse/core/threads/interrupt.h"
#include "shapes/subdivision/triangleTopology.h"

namespace recurse {

namespace {

/** Weight of the mean of the n neighbours of an interior vertex [Kobbelt 2000, (8)]. */
double ringWeight(double n) { return (4 - 2 * std::cos(2 * PI_D / n)) / 9; }

/** Sum of the neighbours of each vertex, on the boundary of the two along it. */
std::vector<Vec3d> sumsOfNeighbours(const TriangleTopology& t, const std::vector<Vec3d>& positions) {
  std::vector<Vec3d> sums(positions.size(), Vec3d(0));
  for (const TriangleTopology::Edge& e : t.edges)
    for (const auto& [v, other] : {std::pair(e.a, e.b), std::pair(e.b, e.a)})
      if (t.boundaryOf[v] == 0 || e.isBoundary()) sums[v] += positions[other];
  return sums;
}

/** Moves vertices towards the mean of their neighbours. */
template <class Inner>
std::vector<Vec3d> movedVertices(const TriangleTopology& t, const std::vector<Vec3d>& positions,
                                 const std::vector<Vec3d>& sums, double weightOnBoundary,
                                 const Inner& weightInside) {
  std::vector<Vec3d> out = positions;
  for (size_t v = 0; v < positions.size(); ++v) {
    if (t.edgesOf[v] == 0) continue;
    const double n = t.boundaryOf[v] > 0 ? 2 : t.edgesOf[v];
    const double w = t.boundaryOf[v] > 0 ? weightOnBoundary : weightInside(n);
    out[v] = positions[v] * (1 - w) + sums[v] * (w / n);
  }
  return out;
}

/** New vertex of a triangle as seen from each of its edges: its middle, or points of its boundary edge. */
using Inserted = std::array<uint32_t, 3>;

} // namespace

void sqrt3Step(MeshData& mesh, bool isEven) {
  const TriangleTopology t(mesh.triangles, mesh.positions.size());
  // On the boundary, two steps are one of the cubic spline with three times as many points.
  const std::vector<Vec3d> sums = sumsOfNeighbours(t, mesh.positions);
  std::vector<Vec3d> positions = movedVertices(t, mesh.positions, sums, isEven ? 8 / 27.0 : 0, ringWeight);
  std::vector<Inserted> inserted(mesh.triangles.size());
  std::vector<glm::uvec3> triangles;
  triangles.reserve(3 * mesh.triangles.size());
  const auto isBoundary = [&](const glm::uvec3& f, int k) {
    return t.edge(f[k], f[(k + 1) % 3]).isBoundary();
  };
  const auto add = [&](const Vec3d& p) {
    positions.push_back(p);
    return static_cast<uint32_t>(positions.size() - 1);
  };
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    checkInterrupted();
    const glm::uvec3& f = mesh.triangles[i];
    int split = -1; // edge that is divided in three; after an odd step a triangle has one at most
    for (int k = 0; k < 3 && isEven; ++k)
      if (isBoundary(f, k)) split = k;
    if (split < 0) {
      inserted[i].fill(add((mesh.positions[f.x] + mesh.positions[f.y] + mesh.positions[f.z]) / 3.0));
      continue;
    }
    const uint32_t a = f[split], b = f[(split + 1) % 3], c = f[(split + 2) % 3];
    const Vec3d before = sums[a] - mesh.positions[b], after = sums[b] - mesh.positions[a];
    const uint32_t u = add((before + 16.0 * mesh.positions[a] + 10.0 * mesh.positions[b]) / 27.0),
                   v = add((10.0 * mesh.positions[a] + 16.0 * mesh.positions[b] + after) / 27.0);
    inserted[i][size_t(split + 1) % 3] = v;
    inserted[i][size_t(split + 2) % 3] = u;
    triangles.emplace_back(u, v, c);
  }
  for (size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const glm::uvec3& f = mesh.triangles[i];
      const uint32_t a = f[k], b = f[(k + 1) % 3], own = inserted[i][size_t(k)];
      const TriangleTopology::Side* other = t.side(b, a);
      if (other) // one half of the flipped edge; the other triangle adds the other half
        triangles.emplace_back(a, inserted[other->triangle][other->edge], own);
      else if (!isEven)
        triangles.emplace_back(a, b, own);
    }
  mesh.positions = std::move(positions);
  mesh.triangles = std::move(triangles);
}

MeshData sqrt3Surface(MeshData mesh, int levels) {
  for (int i = 0; i < levels; ++i) sqrt3Step(mesh, i % 2 == 1);
  const TriangleTopology t(mesh.triangles, mesh.positions.size());
  // Left eigenvector of a step on a vertex and the mean of its ring; at the boundary, of the cubic spline.
  const auto limitWeight = [](double n) { return 3 * ringWeight(n) / (1 + 3 * ringWeight(n)); };
  const std::vector<Vec3d> limits =
      movedVertices(t, mesh.positions, sumsOfNeighbours(t, mesh.positions), 1 / 3.0, limitWeight);
  std::vector<uint32_t> neighbour(mesh.positions.size(), UINT32_MAX);
  mesh.normals.assign(mesh.positions.size(), Vec3d(0));
  for (const glm::uvec3& f : mesh.triangles) {
    const Vec3d across = glm::cross(limits[f.z] - limits[f.x], limits[f.y] - limits[f.x]);
    for (int k = 0; k < 3; ++k) {
      neighbour[f[k]] = f[(k + 1) % 3];
      if (t.boundaryOf[f[k]] > 0) mesh.normals[f[k]] += across;
    }
  }
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    checkInterrupted();
    if (neighbour[v] == UINT32_MAX || t.boundaryOf[v] > 0) continue;
    std::vector<Vec3d> ring;
    for (const uint32_t i : ringAround(t, v, neighbour[v])) ring.push_back(mesh.positions[i]);
    mesh.normals[v] = limitNormal(mesh.positions[v], ring, false);
  }
  mesh.positions = limits;
  return mesh;
}

} // namespace recurse
