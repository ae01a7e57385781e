/** @file
 * Closed triangle meshes as solids: a check that they are closed, and a watertight search for all crossings
 * of a line.
 */
#include "recurse/model/mesh/triangleMesh.h"

#include <map>
#include <numeric>

#include "model/mesh/singles.h"
#include "recurse/model/shape/boxTree.h"

namespace recurse {

namespace {

/** First vertex at the position of each vertex. Seams of texture coordinates do not open a mesh. */
std::vector<uint32_t> weldedVertices(const std::vector<Vec3f>& positions) {
  std::vector<uint32_t> order(positions.size()), welded(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](uint32_t i) {
    const Vec3f& p = positions[i];
    return std::make_tuple(p.x, p.y, p.z, i);
  };
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
  for (size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && positions[order[k]] == positions[order[k - 1]];
    welded[order[k]] = same ? welded[order[k - 1]] : order[k];
  }
  return welded;
}

/** Throws Error unless triangles use each edge equally often in both directions. */
void checkClosed(const std::vector<glm::uvec3>& triangles) {
  struct Use {
    int balance = 0, count = 0;
    uint32_t triangle = 0;
  };
  std::map<std::pair<uint32_t, uint32_t>, Use> edges;
  for (uint32_t i = 0; i < triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = triangles[i][k], b = triangles[i][(k + 1) % 3];
      if (a == b) continue;
      Use& use = edges[std::minmax(a, b)];
      use.balance += a < b ? 1 : -1;
      ++use.count;
      use.triangle = i;
    }
  for (const auto& [edge, use] : edges) {
    if (use.balance == 0) continue;
    const std::string where = "the edge between positions " + std::to_string(edge.first) + " and " +
                              std::to_string(edge.second) + " (triangle " + std::to_string(use.triangle) +
                              ") ";
    if (use.count == 1) throw Error("the mesh is open: " + where + "belongs to one triangle only");
    throw Error("the mesh does not bound a solid: " + where + "is shared by " + std::to_string(use.count) +
                " triangles, with different orientations");
  }
}

uint64_t edgeKey(uint32_t a, uint32_t b) { return uint64_t(std::min(a, b)) << 32 | std::max(a, b); }

/** Keys of the edges that belong to one triangle only, in ascending order. */
std::vector<uint64_t> openEdges(const std::vector<glm::uvec3>& triangles) {
  std::vector<uint64_t> edges;
  edges.reserve(3 * triangles.size());
  for (const glm::uvec3& t : triangles)
    for (int k = 0; k < 3; ++k)
      if (t[k] != t[(k + 1) % 3]) edges.push_back(edgeKey(t[k], t[(k + 1) % 3]));
  keepSingles(edges, [](uint64_t key) { return key; });
  return edges;
}

class MeshSolid final : public Solid {
 public:
  explicit MeshSolid(const TriangleMesh& mesh) : positions(mesh.positions()) {
    const std::vector<uint32_t> welded = weldedVertices(positions);
    std::vector<Bounds3d> boxes;
    double volume = 0;
    for (const glm::uvec3& t : mesh.indices()) {
      triangles.emplace_back(welded[t.x], welded[t.y], welded[t.z]);
      Bounds3d box;
      for (int k = 0; k < 3; ++k) box.add(Vec3d(positions[t[k]]));
      boxes.push_back(box);
      volume += glm::dot(Vec3d(positions[t.x]), glm::cross(Vec3d(positions[t.y]), Vec3d(positions[t.z])));
    }
    checkClosed(triangles);
    windsInwards = volume < 0;
    tree = BoxTree(boxes);
    // The normal of surfaceAt() decides: vertex normals may have flipped it against the winding.
    if (!triangles.empty()) {
      const glm::uvec3& t = mesh.indices()[0];
      const Vec3d winding = glm::cross(Vec3d(positions[t.y]) - Vec3d(positions[t.x]),
                                       Vec3d(positions[t.z]) - Vec3d(positions[t.x]));
      const Vec3d normal(mesh.placeAt(0, HitParameters(Vec2f(1 / 3.0f))).geometricNormal);
      inwards = (glm::dot(winding, normal) < 0) != windsInwards;
    }
  }

  void crossings(const Vec3d& origin, const Vec3d& direction, std::vector<Crossing>& found) const override {
    // Shear of the line to the z axis (Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", 2013).
    const int axis = widestAxis(glm::abs(direction)), xAxis = (axis + 1) % 3, yAxis = (axis + 2) % 3;
    const double shearX = direction[xAxis] / direction[axis], shearY = direction[yAxis] / direction[axis];
    const auto sheared = [&](uint32_t vertex) {
      const Vec3d p = Vec3d(positions[vertex]) - origin;
      return Vec3d(p[xAxis] - shearX * p[axis], p[yAxis] - shearY * p[axis], p[axis] / direction[axis]);
    };
    // Sign of an edge's determinant: consistent for both of its triangles, also where it is zero.
    const auto edge = [](const Vec3d& a, const Vec3d& b, uint32_t ia, uint32_t ib, bool& positive) {
      const double e = ia < ib ? a.x * b.y - a.y * b.x : -(b.x * a.y - b.y * a.x);
      positive = e > 0 || (e == 0 && ia < ib);
      return e;
    };
    constexpr double ENDLESS = std::numeric_limits<double>::infinity();
    tree.visit(origin, direction, -ENDLESS, ENDLESS, [&](uint32_t i) {
      const glm::uvec3& t = triangles[i];
      if (t.x == t.y || t.y == t.z || t.z == t.x) return;
      const Vec3d a = sheared(t.x), b = sheared(t.y), c = sheared(t.z);
      bool positiveA, positiveB, positiveC;
      const double weightA = edge(b, c, t.y, t.z, positiveA), weightB = edge(c, a, t.z, t.x, positiveB),
                   weightC = edge(a, b, t.x, t.y, positiveC);
      if (positiveA != positiveB || positiveB != positiveC) return;
      const double sum = weightA + weightB + weightC;
      if (sum == 0) return;
      const double u = weightB / sum, v = weightC / sum;
      // Positive: the winding is counterclockwise along +z of the sheared space, seen from behind.
      const bool fromBehind = positiveA != (direction[axis] < 0);
      found.push_back(
          {a.z * (1 - u - v) + b.z * u + c.z * v, fromBehind == windsInwards, i, HitParameters(Vec2f(u, v))});
    });
  }
  bool normalsPointIn() const override { return inwards; }

 private:
  const std::vector<Vec3f>& positions;
  std::vector<glm::uvec3> triangles;
  BoxTree tree;
  bool windsInwards = false, inwards = false;
};

} // namespace

std::vector<RimPiece> TriangleMesh::rim() const {
  const std::vector<Vec3f>& positions = this->positions();
  std::vector<glm::uvec3> triangles = indices();
  if (openEdges(triangles).empty()) return {};
  const std::vector<uint32_t> welded = weldedVertices(positions);
  for (glm::uvec3& t : triangles) t = {welded[t.x], welded[t.y], welded[t.z]};
  const std::vector<uint64_t> open = openEdges(triangles);
  std::vector<RimPiece> rim;
  for (const glm::uvec3& t : triangles)
    for (int k = 0; k < 3; ++k)
      if (const uint32_t a = t[k], b = t[(k + 1) % 3];
          std::binary_search(open.begin(), open.end(), edgeKey(a, b)))
        rim.push_back({positions[a], positions[b], positions[t[(k + 2) % 3]]});
  return rim;
}

std::unique_ptr<Solid> TriangleMesh::asSolid() const { return std::make_unique<MeshSolid>(*this); }

} // namespace recurse
