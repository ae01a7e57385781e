/** @file
 * Loop's subdivision surfaces as in pbrt-v4: triangles are split level by level, then moved to the limit
 * surface, with its normals (Loop, "Smooth Subdivision Surfaces Based on Triangles", 1987). The scheme √3 of
 * sqrt3.h has the same parameters.
 */
#include "recurse/core/threads/interrupt.h"
#include "recurse/core/threads/resources.h"
#include "recurse/model/mesh/displacement.h"
#include "recurse/model/scene/plugIns.h"
#include "shapes/subdivision/sqrt3.h"
#include "shapes/subdivision/triangleTopology.h"

namespace recurse {

namespace {

/** Weight of each neighbour of an interior vertex: Warren's, as in pbrt. */
double neighbourWeight(double valence) { return valence == 3 ? 3 / 16.0 : 3 / (8 * valence); }
double limitWeight(double valence) { return 1 / (valence + 3 / (8 * neighbourWeight(valence))); }

/** Averages each vertex with its neighbours. A vertex on the boundary is averaged with its neighbours
 * along the boundary only, with a separate weight. */
template <class Inner>
std::vector<Vec3d> averaged(const TriangleTopology& t, const std::vector<Vec3d>& positions,
                            double boundaryWeight, const Inner& weightInside) {
  std::vector<Vec3d> sums(positions.size(), Vec3d(0));
  for (const TriangleTopology::Edge& e : t.edges)
    for (const auto& [v, other] : {std::pair(e.a, e.b), std::pair(e.b, e.a)})
      if (t.boundaryOf[v] == 0 || e.isBoundary()) sums[v] += positions[other];
  std::vector<Vec3d> out(positions.size());
  for (size_t v = 0; v < positions.size(); ++v) {
    const double n = t.boundaryOf[v] > 0 ? 2 : t.edgesOf[v];
    const double w = t.boundaryOf[v] > 0 ? boundaryWeight : n > 0 ? weightInside(n) : 0;
    out[v] = positions[v] * (1 - n * w) + sums[v] * w;
  }
  return out;
}

void splitOnce(MeshData& mesh) {
  const TriangleTopology t(mesh.triangles, mesh.positions.size());
  std::vector<Vec3d> positions = averaged(t, mesh.positions, 1 / 8.0, neighbourWeight);
  const auto first = static_cast<uint32_t>(positions.size());
  for (const TriangleTopology::Edge& e : t.edges) {
    const Vec3d ends = mesh.positions[e.a] + mesh.positions[e.b];
    positions.push_back(e.isBoundary()
                            ? 0.5 * ends
                            : 3 / 8.0 * ends +
                                  1 / 8.0 * (mesh.positions[e.opposite[0]] + mesh.positions[e.opposite[1]]));
  }
  std::vector<glm::uvec3> triangles;
  triangles.reserve(4 * mesh.triangles.size());
  for (const glm::uvec3& f : mesh.triangles) {
    checkInterrupted();
    glm::uvec3 middle;
    for (int k = 0; k < 3; ++k) middle[k] = first + static_cast<uint32_t>(t.edgeNumber(f[k], f[(k + 1) % 3]));
    triangles.emplace_back(f.x, middle.x, middle.z);
    triangles.emplace_back(middle.x, f.y, middle.y);
    triangles.emplace_back(middle.z, middle.y, f.z);
    triangles.push_back(middle);
  }
  mesh.positions = std::move(positions);
  mesh.triangles = std::move(triangles);
}

MeshData subdivided(MeshData mesh, int levels) {
  for (int i = 0; i < levels; ++i) splitOnce(mesh);
  const TriangleTopology t(mesh.triangles, mesh.positions.size());
  mesh.positions = averaged(t, mesh.positions, 1 / 5.0, limitWeight);
  std::vector<uint32_t> neighbour(mesh.positions.size(), UINT32_MAX);
  for (const glm::uvec3& f : mesh.triangles)
    for (int k = 0; k < 3; ++k) neighbour[f[k]] = f[(k + 1) % 3];
  mesh.normals.assign(mesh.positions.size(), Vec3d(0));
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    checkInterrupted();
    if (neighbour[v] == UINT32_MAX) continue;
    std::vector<Vec3d> ring;
    for (const uint32_t i : ringAround(t, v, neighbour[v])) ring.push_back(mesh.positions[i]);
    mesh.normals[v] = limitNormal(mesh.positions[v], ring, t.boundaryOf[v] > 0);
  }
  return mesh;
}

std::unique_ptr<Shape> makeLoopSubdivision(const Parameters& p, const ShapeContext& context) {
  MeshData mesh;
  mesh.positions = p.vector3s("P");
  const std::vector<int> indices = p.integers("indices");
  if (indices.size() % 3 != 0)
    p.fail("indices", std::to_string(indices.size()) + " indices do not form triangles",
           "three for each triangle");
  for (size_t i = 0; i < indices.size(); ++i)
    if (indices[i] < 0 || size_t(indices[i]) >= mesh.positions.size())
      p.fail("indices",
             "index " + std::to_string(indices[i]) + " (number " + std::to_string(i + 1) +
                 " of the list) is not the index of a position",
             "0 to " + std::to_string(int64_t(mesh.positions.size()) - 1));
  for (size_t i = 0; i < indices.size(); i += 3) {
    mesh.triangles.emplace_back(indices[i], indices[i + 1], indices[i + 2]);
    const glm::uvec3 t = mesh.triangles.back();
    if (t.x == t.y || t.y == t.z || t.z == t.x)
      p.fail("indices", "triangle " + std::to_string(i / 3) + " uses a vertex twice", "three positions");
  }
  const int levels = p.integer("levels");
  constexpr double MOST_TRIANGLES = 2e8;
  const bool isSqrt3 = p.string("scheme") == "sqrt3";
  const double triangles = double(mesh.triangles.size()) * std::pow(isSqrt3 ? 3.0 : 4.0, levels);
  if (triangles > MOST_TRIANGLES)
    p.fail("levels", "that makes more than " + std::to_string(int(MOST_TRIANGLES)) + " triangles",
           "fewer levels");
  // Memory per triangle [bytes]: one and a half edges, three entries in tables of edges and half a vertex.
  constexpr double TRIANGLE_BYTES = 300;
  constexpr double TRIANGLE_SECONDS = 5e-6;
  const std::string subject = "subdivision by " + std::to_string(levels) + " levels";
  requireWork(subject, TRIANGLE_SECONDS * triangles);
  requireMemory(subject, TRIANGLE_BYTES * triangles);
  try {
    mesh = isSqrt3 ? sqrt3Surface(std::move(mesh), levels) : subdivided(std::move(mesh), levels);
    return makeDisplacedMesh(std::move(mesh), p, context);
  } catch (const SceneError&) {
    throw;
  } catch (const Interrupted&) {
    throw;
  } catch (const Error& e) {
    p.fail("indices", e.what());
  }
}

} // namespace

void registerLoopSubdiv(PlugIns& plugIns) {
  plugIns.shapes.add(
      {{.name = "loopsubdiv",
        .summary = "A smooth surface from a control mesh of triangles, by subdivision of Loop or of Kobbelt "
                   "(√3). As "
                   "in pbrt-v4, on its outside the vertices of the triangles are clockwise.",
        .parameters = withDisplacement(
            {integerParameter(
                 "levels", "3",
                 "number of subdivision steps; each splits a triangle into four, with \"sqrt3\" into three")
                 .range(0, 12),
             arrayParameter(ParameterType::INTEGER, "indices", 0, "",
                            "vertex indices, three for each triangle, all with the same orientation")
                 .range(0, std::numeric_limits<int>::max())
                 .require(),
             arrayParameter(ParameterType::POINT3, "P", 0, "", "positions of the control mesh").require(),
             stringParameter("scheme", "loop",
                             "\"loop\", or \"sqrt3\", which turns the edges and refines more gently")
                 .oneOf({"loop", "sqrt3"})}),
        .examples = {"\"integer levels\" 2 \"point3 P\" [1 1 1  -1 -1 1  -1 1 -1  1 -1 -1] "
                     "\"integer indices\" [0 2 1  0 1 3  1 2 3  2 0 3]",
                     "\"integer levels\" 1 \"point3 P\" [0 0 0  1 0 .2  0 1 0  1 1 -.3  2 .5 0] "
                     "\"integer indices\" [0 1 2  1 3 2  1 4 3]",
                     "\"string scheme\" \"sqrt3\" \"integer levels\" 3 \"point3 P\" [0 0 0  1 0 .2  0 1 0  1 "
                     "1 -.3  2 .5 0] "
                     "\"integer indices\" [0 1 2  1 3 2  1 4 3]"}},
       makeLoopSubdivision});
}

} // namespace recurse
