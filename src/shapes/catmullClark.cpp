/** @file
 * Subdivision surfaces of Catmull and Clark, "Recursively Generated B-Spline Surfaces on Arbitrary
 * Topological Meshes" (1978): faces are split level by level, then moved to the limit surface, with its
 * normals.
 */
#include <unordered_map>

#include "recurse/model/plugIns.h"
#include "recurse/model/triangleMesh.h"

namespace recurse {

namespace {

constexpr double PI_D = 3.14159265358979323846;

struct Polygons {
  std::vector<Vec3d> positions;
  std::vector<Vec2d> uvs; ///< one for each position, or none
  std::vector<std::vector<uint32_t>> faces;
};

/** The edges of a mesh; a boundary edge has one face. */
struct Edges {
  struct Edge {
    uint32_t a, b;
    uint32_t face[2];
    int faces = 0;
    bool isBoundary() const { return faces == 1; }
  };
  std::vector<Edge> list;
  std::vector<uint32_t> ofVertex, boundaryOfVertex; ///< numbers of edges at each

  explicit Edges(const Polygons& mesh) : ofVertex(mesh.positions.size(), 0), boundaryOfVertex(ofVertex) {
    std::unordered_map<uint64_t, bool> directed;
    for (uint32_t f = 0; f < mesh.faces.size(); ++f)
      for (size_t k = 0; k < mesh.faces[f].size(); ++k) {
        const uint32_t a = mesh.faces[f][k], b = mesh.faces[f][(k + 1) % mesh.faces[f].size()];
        if (!directed.emplace(key(a, b), true).second)
          throw Error("the edge from position " + std::to_string(a) + " to " + std::to_string(b) +
                      " belongs to two faces that are turned against each other, or to three");
        const auto [found, isNew] = numbers.emplace(key(std::min(a, b), std::max(a, b)), list.size());
        if (isNew) list.push_back({std::min(a, b), std::max(a, b), {0, 0}, 0});
        Edge& e = list[found->second];
        e.face[e.faces++] = f;
      }
    for (const Edge& e : list)
      for (const uint32_t v : {e.a, e.b}) {
        ++ofVertex[v];
        boundaryOfVertex[v] += e.isBoundary();
      }
    for (size_t v = 0; v < ofVertex.size(); ++v)
      if (boundaryOfVertex[v] > 2)
        throw Error("at position " + std::to_string(v) + " parts of the surface touch in a point only");
  }
  size_t number(uint32_t a, uint32_t b) const { return numbers.at(key(std::min(a, b), std::max(a, b))); }

 private:
  static uint64_t key(uint32_t a, uint32_t b) { return uint64_t(a) << 32 | b; }
  std::unordered_map<uint64_t, size_t> numbers;
};

/** The values of the next level: of vertices, edges and faces in that order. */
template <class V>
std::vector<V> refined(const std::vector<V>& values, const Polygons& mesh, const Edges& edges) {
  std::vector<V> ofFaces, ofEdges, out(values.size(), V(0));
  std::vector<V> facesAround(values.size(), V(0)), middlesAround(values.size(), V(0));
  for (const auto& face : mesh.faces) {
    V sum(0);
    for (const uint32_t v : face) sum += values[v];
    ofFaces.push_back(sum / double(face.size()));
    for (const uint32_t v : face) facesAround[v] += ofFaces.back();
  }
  for (const Edges::Edge& e : edges.list) {
    const V middle = 0.5 * (values[e.a] + values[e.b]);
    ofEdges.push_back(e.isBoundary() ? middle
                                     : 0.5 * middle + 0.25 * (ofFaces[e.face[0]] + ofFaces[e.face[1]]));
    for (const uint32_t v : {e.a, e.b})
      if (edges.boundaryOfVertex[v] == 0 || e.isBoundary()) middlesAround[v] += middle;
  }
  for (size_t v = 0; v < values.size(); ++v) {
    const double n = edges.ofVertex[v];
    if (edges.boundaryOfVertex[v] > 0)
      out[v] = 0.5 * values[v] + 0.25 * middlesAround[v];
    else if (n > 0)
      out[v] = (facesAround[v] / n + 2.0 * middlesAround[v] / n + (n - 3) * values[v]) / n;
    else
      out[v] = values[v];
  }
  out.insert(out.end(), ofEdges.begin(), ofEdges.end());
  out.insert(out.end(), ofFaces.begin(), ofFaces.end());
  return out;
}

Polygons splitOnce(const Polygons& mesh) {
  const Edges edges(mesh);
  Polygons out;
  out.positions = refined(mesh.positions, mesh, edges);
  if (!mesh.uvs.empty()) out.uvs = refined(mesh.uvs, mesh, edges);
  const auto firstEdge = static_cast<uint32_t>(mesh.positions.size());
  const auto firstFace = firstEdge + static_cast<uint32_t>(edges.list.size());
  for (uint32_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& face = mesh.faces[f];
    const size_t n = face.size();
    for (size_t k = 0; k < n; ++k)
      out.faces.push_back(
          {face[k], firstEdge + static_cast<uint32_t>(edges.number(face[k], face[(k + 1) % n])),
           firstFace + f, firstEdge + static_cast<uint32_t>(edges.number(face[k], face[(k + n - 1) % n]))});
  }
  return out;
}

/** Of quadrilaterals: the limit of each vertex, and its normal (Halstead, Kass, DeRose, "Efficient, Fair
 * Interpolation using Catmull-Clark Surfaces", 1993); on the boundary the mean of the faces' normals. */
MeshData limitOf(const Polygons& mesh) {
  const Edges edges(mesh);
  const size_t count = mesh.positions.size();
  // What follows a neighbour around a vertex, and the corner between the two.
  std::vector<std::vector<std::array<uint32_t, 3>>> around(count);
  std::vector<Vec3d> faceNormals(count, Vec3d(0)), boundaryEnds(count, Vec3d(0));
  for (const auto& f : mesh.faces)
    for (size_t k = 0; k < 4; ++k) {
      const uint32_t v = f[k], next = f[(k + 1) % 4], across = f[(k + 2) % 4], last = f[(k + 3) % 4];
      around[v].push_back({next, across, last});
      faceNormals[v] +=
          glm::cross(mesh.positions[next] - mesh.positions[v], mesh.positions[last] - mesh.positions[v]);
    }
  for (const Edges::Edge& e : edges.list)
    if (e.isBoundary()) {
      boundaryEnds[e.a] += mesh.positions[e.b];
      boundaryEnds[e.b] += mesh.positions[e.a];
    }
  MeshData out;
  out.uvs = mesh.uvs;
  out.positions = mesh.positions;
  out.normals = faceNormals;
  for (size_t v = 0; v < count; ++v) {
    auto& ring = around[v];
    if (ring.empty()) continue;
    if (edges.boundaryOfVertex[v] > 0) {
      out.positions[v] = (4.0 * mesh.positions[v] + boundaryEnds[v]) / 6.0;
      continue;
    }
    for (size_t i = 0; i + 1 < ring.size(); ++i) // in order: each begins where the one before ends
      for (size_t k = i + 1; k < ring.size(); ++k)
        if (ring[k][0] == ring[i][2]) {
          std::swap(ring[i + 1], ring[k]);
          break;
        }
    const double n = double(ring.size()), turn = 2 * PI_D / n;
    const double weight = 1 + std::cos(turn) + std::cos(0.5 * turn) * std::sqrt(2 * (9 + std::cos(turn)));
    Vec3d sum = n * n * mesh.positions[v], s(0), t(0);
    for (size_t i = 0; i < ring.size(); ++i) {
      const Vec3d &e = mesh.positions[ring[i][0]], &f = mesh.positions[ring[i][1]];
      const double a = turn * double(i), b = turn * double(i + 1);
      sum += 4.0 * e + f;
      s += weight * std::cos(a) * e + (std::cos(a) + std::cos(b)) * f;
      t += weight * std::sin(a) * e + (std::sin(a) + std::sin(b)) * f;
    }
    out.positions[v] = sum / (n * (n + 5));
    const Vec3d normal = glm::cross(s, t);
    out.normals[v] = glm::dot(normal, faceNormals[v]) < 0 ? -normal : normal;
  }
  for (const auto& f : mesh.faces) {
    out.triangles.emplace_back(f[0], f[1], f[2]);
    out.triangles.emplace_back(f[0], f[2], f[3]);
  }
  return out;
}

Polygons controlMesh(const Parameters& p) {
  Polygons mesh;
  mesh.positions = p.vector3s("P");
  if (p.has("uv")) {
    mesh.uvs = p.vector2s("uv");
    if (mesh.uvs.size() != mesh.positions.size())
      p.fail("uv",
             std::to_string(mesh.uvs.size()) + " given for " + std::to_string(mesh.positions.size()) +
                 " positions",
             "one for each element of \"P\"");
  }
  const std::vector<int> indices = p.integers("indices");
  std::vector<int> corners;
  if (p.has("corners")) corners = p.integers("corners");
  if (corners.empty()) corners.assign(indices.size() / 4, 4);
  size_t next = 0;
  for (const int n : corners) {
    if (next + size_t(n) > indices.size()) p.fail("corners", "they add up to more than there are indices");
    auto& face = mesh.faces.emplace_back();
    for (int k = 0; k < n; ++k) {
      const int i = indices[next++];
      if (i < 0 || size_t(i) >= mesh.positions.size())
        p.fail("indices",
               "index " + std::to_string(i) + " (number " + std::to_string(next) +
                   " of the list) names no position",
               "0 to " + std::to_string(int64_t(mesh.positions.size()) - 1));
      if (std::find(face.begin(), face.end(), uint32_t(i)) != face.end())
        p.fail("indices", "face " + std::to_string(mesh.faces.size() - 1) + " has a corner twice");
      face.push_back(uint32_t(i));
    }
  }
  if (next != indices.size())
    p.fail("indices", std::to_string(indices.size() - next) + " indices belong to no face",
           "as many as \"corners\" add up to; four for each face without them");
  return mesh;
}

std::unique_ptr<Shape> makeCatmullClark(const Parameters& p, const ShapeContext& context) {
  Polygons mesh = controlMesh(p);
  const int levels = p.integer("levels");
  constexpr double MOST_FACES = 1e8;
  if (double(mesh.faces.size()) * std::pow(4.0, levels) > MOST_FACES)
    p.fail("levels", "that makes more than " + std::to_string(int(MOST_FACES)) + " faces", "fewer levels");
  try {
    for (int i = 0; i < levels; ++i) mesh = splitOnce(mesh);
    return std::make_unique<TriangleMesh>(limitOf(mesh), context);
  } catch (const Error& e) {
    p.fail("indices", e.what());
  }
}

} // namespace

void registerCatmullClark(PlugIns& plugIns) {
  plugIns.shapes.add(
      {{.name = "catmullclark",
        .summary =
            "A smooth surface that a mesh of polygons controls, by Catmull's and Clark's subdivision. Its "
            "outside is where the faces are seen counterclockwise from.",
        .parameters =
            {integerParameter("levels", "3", "how often each face is split").range(1, 12),
             arrayParameter(ParameterType::INTEGER, "indices", 0, "",
                            "numbers of positions, face by face, all turned the same way")
                 .range(0, std::numeric_limits<int>::max())
                 .require(),
             arrayParameter(ParameterType::INTEGER, "corners", 0, "",
                            "how many corners each face has; all have four when absent")
                 .range(3, 1000),
             arrayParameter(ParameterType::POINT3, "P", 0, "", "positions of the control mesh").require(),
             arrayParameter(ParameterType::POINT2, "uv", 0, "",
                            "texture coordinates at the positions, made smooth as these are")},
        .examples =
            {"\"integer levels\" 2 \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0  0 0 1  1 0 1  0 1 1  1 1 1] "
             "\"integer indices\" [0 2 3 1  4 5 7 6  0 1 5 4  2 6 7 3  0 4 6 2  1 3 7 5]",
             "\"integer levels\" 1 \"point3 P\" [0 0 0  1 0 0  1 1 .3  0 1 0  2 .5 0] "
             "\"integer corners\" [4 3] \"integer indices\" [0 1 2 3  1 4 2] "
             "\"point2 uv\" [0 0  .5 0  .5 1  0 1  1 .5]"}},
       makeCatmullClark});
}

} // namespace recurse
