/** @file
 * Loop's subdivision surfaces as in pbrt-v4: triangles are split level by level, then moved to the limit
 * surface, with its normals (Loop, "Smooth Subdivision Surfaces Based on Triangles", 1987).
 */
#include <unordered_map>

#include "recurse/core/threads/interrupt.h"
#include "recurse/core/threads/resources.h"
#include "recurse/model/mesh/displacement.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Edges of a triangle mesh, and the neighbourhood of each vertex. */
class Topology {
 public:
  struct Edge {
    uint32_t a, b;        ///< vertices
    uint32_t opposite[2]; ///< third vertices of the one or two triangles
    int triangles = 0;
    bool isBoundary() const { return triangles == 1; }
  };

  Topology(const std::vector<glm::uvec3>& triangles, size_t vertexCount)
      : edgesOf(vertexCount, 0), boundaryOf(vertexCount, 0) {
    for (const glm::uvec3& t : triangles) {
      checkInterrupted();
      for (int k = 0; k < 3; ++k) {
        const uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
        if (!directed.emplace(key(a, b), c).second)
          throw Error("the edge from position " + std::to_string(a) + " to " + std::to_string(b) +
                      " belongs to two triangles with opposite orientations, or to three triangles");
        const auto [found, isNew] = numbers.emplace(key(std::min(a, b), std::max(a, b)), edges.size());
        if (isNew) edges.push_back({std::min(a, b), std::max(a, b), {0, 0}, 0});
        Edge& e = edges[found->second];
        e.opposite[e.triangles++] = c;
      }
    }
    for (const Edge& e : edges)
      for (const uint32_t v : {e.a, e.b}) {
        ++edgesOf[v];
        boundaryOf[v] += e.isBoundary();
      }
    for (size_t v = 0; v < vertexCount; ++v)
      if (boundaryOf[v] > 2)
        throw Error("at position " + std::to_string(v) + " parts of the surface touch in a point only");
  }

  size_t edgeNumber(uint32_t a, uint32_t b) const { return numbers.at(key(std::min(a, b), std::max(a, b))); }
  /** Vertex after `from` around `v`: the third vertex of the triangle v, from, ...; null at the boundary. */
  const uint32_t* next(uint32_t v, uint32_t from) const {
    const auto found = directed.find(key(v, from));
    return found == directed.end() ? nullptr : &found->second;
  }

  std::vector<Edge> edges;
  std::vector<uint32_t> edgesOf, boundaryOf; ///< numbers of edges, and of boundary edges, at a vertex

 private:
  static uint64_t key(uint32_t a, uint32_t b) { return uint64_t(a) << 32 | b; }
  std::unordered_map<uint64_t, size_t> numbers;
  std::unordered_map<uint64_t, uint32_t> directed;
};

/** Weight of each neighbour of an interior vertex: Warren's, as in pbrt. */
double neighbourWeight(double valence) { return valence == 3 ? 3 / 16.0 : 3 / (8 * valence); }
double limitWeight(double valence) { return 1 / (valence + 3 / (8 * neighbourWeight(valence))); }

/** Averages each vertex with its neighbours. A vertex on the boundary is averaged with its neighbours
 * along the boundary only, with a separate weight. */
template <class Inner>
std::vector<Vec3d> averaged(const Topology& t, const std::vector<Vec3d>& positions, double boundaryWeight,
                            const Inner& weightInside) {
  std::vector<Vec3d> sums(positions.size(), Vec3d(0));
  for (const Topology::Edge& e : t.edges)
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
  const Topology t(mesh.triangles, mesh.positions.size());
  std::vector<Vec3d> positions = averaged(t, mesh.positions, 1 / 8.0, neighbourWeight);
  const auto first = static_cast<uint32_t>(positions.size());
  for (const Topology::Edge& e : t.edges) {
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

/** Neighbours in order around a vertex; on the boundary, from its first boundary edge to its last. */
std::vector<uint32_t> ringAround(const Topology& t, uint32_t v, uint32_t any) {
  std::vector<uint32_t> ring{any};
  if (t.boundaryOf[v] > 0) { // back to the first, which has no predecessor
    for (uint32_t steps = 0; steps < t.edgesOf[v]; ++steps) {
      // The triangle v, x, ring.front() is also ring.front(), v, x.
      const uint32_t* before = t.next(ring.front(), v);
      if (!before) break;
      ring.front() = *before;
    }
  }
  while (ring.size() < t.edgesOf[v]) {
    const uint32_t* after = t.next(v, ring.back());
    if (!after) break;
    ring.push_back(*after);
  }
  return ring;
}

/** Normal of the limit surface from the ring around a vertex (Hoppe et al., "Piecewise Smooth Surface
 * Reconstruction", 1994). As in pbrt-v4, triangles are clockwise as seen from the outside. */
Vec3d limitNormal(const Vec3d& v, const std::vector<Vec3d>& ring, bool onBoundary) {
  const size_t n = ring.size();
  Vec3d s(0), t(0);
  if (!onBoundary) {
    for (size_t i = 0; i < n; ++i) {
      s += ring[i] * std::cos(2 * PI_D * double(i) / double(n));
      t += ring[i] * std::sin(2 * PI_D * double(i) / double(n));
    }
  } else {
    s = ring.front() - ring.back();
    if (n == 2) {
      t = ring[0] + ring[1] - 2.0 * v;
    } else if (n == 3) {
      t = ring[1] - v;
    } else if (n == 4) {
      t = 2.0 * (ring[1] + ring[2]) - ring[0] - ring[3] - 2.0 * v;
    } else {
      const double theta = PI_D / double(n - 1);
      t = (ring.front() + ring.back()) * -std::sin(theta);
      for (size_t k = 1; k + 1 < n; ++k)
        t += ring[k] * ((2 - 2 * std::cos(theta)) * std::sin(double(k) * theta));
    }
  }
  Vec3d normal = glm::cross(s, t), winding(0);
  for (size_t i = 0; i + (onBoundary ? 1 : 0) < n; ++i)
    winding += glm::cross(ring[i] - v, ring[(i + 1) % n] - v);
  return glm::dot(normal, winding) > 0 ? -normal : normal;
}

MeshData subdivided(MeshData mesh, int levels) {
  for (int i = 0; i < levels; ++i) splitOnce(mesh);
  const Topology t(mesh.triangles, mesh.positions.size());
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
  const double triangles = double(mesh.triangles.size()) * std::pow(4.0, levels);
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
    return makeDisplacedMesh(subdivided(std::move(mesh), levels), p, context);
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
        .summary = "A smooth surface from a control mesh of triangles, by Loop subdivision. As in pbrt-v4, "
                   "on its outside the vertices of the triangles are clockwise.",
        .parameters = withDisplacement(
            {integerParameter("levels", "3", "number of subdivision steps; each splits a triangle into four")
                 .range(0, 12),
             arrayParameter(ParameterType::INTEGER, "indices", 0, "",
                            "vertex indices, three for each triangle, all with the same orientation")
                 .range(0, std::numeric_limits<int>::max())
                 .require(),
             arrayParameter(ParameterType::POINT3, "P", 0, "", "positions of the control mesh").require(),
             ignoredParameter(ParameterType::STRING, "scheme", "only \"loop\" exists in pbrt")}),
        .examples = {"\"integer levels\" 2 \"point3 P\" [1 1 1  -1 -1 1  -1 1 -1  1 -1 -1] "
                     "\"integer indices\" [0 2 1  0 1 3  1 2 3  2 0 3]",
                     "\"integer levels\" 1 \"point3 P\" [0 0 0  1 0 .2  0 1 0  1 1 -.3  2 .5 0] "
                     "\"integer indices\" [0 1 2  1 3 2  1 4 3]"}},
       makeLoopSubdivision});
}

} // namespace recurse
