/** @file
 * Steps and limits of Doo-Sabin subdivision.
 */
#include "shapes/subdivision/dooSabin.h"

#include <span>
#include <unordered_map>

#include "recurse/core/threads/interrupt.h"

namespace recurse {

namespace {

constexpr uint32_t NO_CORNER = UINT32_MAX;

/** Neighbours of the corners of a polygon mesh. A corner also stands for the edge that starts there. */
class Corners {
 public:
  explicit Corners(const PolygonMesh& mesh) : mesh(mesh), faces(mesh.vertices.size()), across(faces.size()) {
    std::unordered_map<uint64_t, uint32_t> edges;
    edges.reserve(faces.size());
    for (uint32_t f = 0; f < mesh.faceCount(); ++f)
      for (uint32_t c = mesh.starts[f]; c < mesh.starts[f + 1]; ++c) faces[c] = f;
    for (uint32_t c = 0; c < faces.size(); ++c) edges.emplace(key(vertex(c), vertex(next(c))), c);
    for (uint32_t c = 0; c < faces.size(); ++c) {
      const auto found = edges.find(key(vertex(next(c)), vertex(c)));
      across[c] = found == edges.end() ? NO_CORNER : found->second;
    }
  }

  uint32_t count() const { return static_cast<uint32_t>(faces.size()); }
  uint32_t face(uint32_t c) const { return faces[c]; }
  uint32_t vertex(uint32_t c) const { return mesh.vertices[c]; }
  uint32_t next(uint32_t c) const {
    const uint32_t f = faces[c];
    return c + 1 < mesh.starts[f + 1] ? c + 1 : mesh.starts[f];
  }
  uint32_t previous(uint32_t c) const {
    const uint32_t f = faces[c];
    return c > mesh.starts[f] ? c - 1 : mesh.starts[f + 1] - 1;
  }
  /** Start of the same edge in the face on its other side; NO_CORNER on the boundary. */
  uint32_t opposite(uint32_t c) const { return across[c]; }
  bool isBoundary(uint32_t c) const { return across[c] == NO_CORNER; }

  /**
   * Calls visit(corners, isClosed) for the corners around each vertex, counterclockwise: all of them, or
   * those from the edge that leaves along the boundary to the edge that arrives along it.
   */
  template <class Visit> void forVertices(const Visit& visit) const {
    std::vector<bool> isDone(count(), false);
    std::vector<uint32_t> around;
    for (const bool closed : {false, true}) // fans of the boundary first, from their ends
      for (uint32_t c = 0; c < count(); ++c) {
        if (isDone[c] || isBoundary(c) == closed) continue;
        around.clear();
        for (uint32_t at = c; at != NO_CORNER && !isDone[at]; at = across[previous(at)]) {
          isDone[at] = true;
          around.push_back(at);
        }
        visit(around, closed);
      }
  }

 private:
  static uint64_t key(uint32_t a, uint32_t b) { return uint64_t(a) << 32 | b; }

  const PolygonMesh& mesh;
  std::vector<uint32_t> faces, across;
};

/** New vertices at the corners of a face of n corners: the weight of corner j in that of corner k is
 * (3 + 2 cos(2π (j - k) / n)) / (4 n), plus 1/4 for j = k. The sums are the Fourier coefficients 0 and 1. */
template <class V> void addCornerPoints(std::span<const V> corners, std::vector<V>& out) {
  const double n = double(corners.size());
  V sum(0), cosines(0), sines(0);
  for (size_t k = 0; k < corners.size(); ++k) {
    sum += corners[k];
    cosines += corners[k] * std::cos(2 * PI_D * double(k) / n);
    sines += corners[k] * std::sin(2 * PI_D * double(k) / n);
  }
  for (size_t k = 0; k < corners.size(); ++k) {
    const double angle = 2 * PI_D * double(k) / n;
    out.push_back(corners[k] * 0.25 +
                  (sum * 1.5 + cosines * std::cos(angle) + sines * std::sin(angle)) / (2 * n));
  }
}

template <class V>
std::vector<V> refinedValues(const PolygonMesh& mesh, const Corners& corners, const std::vector<V>& values) {
  std::vector<V> out, ofFace;
  for (size_t f = 0; f + 1 < mesh.starts.size(); ++f) {
    checkInterrupted();
    ofFace.clear();
    for (uint32_t c = mesh.starts[f]; c < mesh.starts[f + 1]; ++c) ofFace.push_back(values[mesh.vertices[c]]);
    addCornerPoints<V>(ofFace, out);
  }
  for (uint32_t c = 0; c < corners.count(); ++c) {
    if (!corners.isBoundary(c)) continue;
    const V &a = values[corners.vertex(c)], &b = values[corners.vertex(corners.next(c))];
    out.push_back(a * 0.75 + b * 0.25);
    out.push_back(a * 0.25 + b * 0.75);
  }
  return out;
}

template <class V> V centre(const PolygonMesh& mesh, const std::vector<V>& values, uint32_t face) {
  V sum(0);
  for (uint32_t c = mesh.starts[face]; c < mesh.starts[face + 1]; ++c) sum += values[mesh.vertices[c]];
  return sum / double(mesh.starts[face + 1] - mesh.starts[face]);
}

/** Normal of the limit surface at the centre of a face: its tangents are the first Fourier coefficients. */
Vec3d limitNormalOfFace(const PolygonMesh& mesh, uint32_t face) {
  const uint32_t first = mesh.starts[face], n = mesh.starts[face + 1] - first;
  Vec3d s(0), t(0);
  for (uint32_t k = 0; k < n; ++k) {
    const Vec3d& p = mesh.positions[mesh.vertices[first + k]];
    s += p * std::cos(2 * PI_D * k / n);
    t += p * std::sin(2 * PI_D * k / n);
  }
  return glm::cross(s, t);
}

} // namespace

PolygonMesh dooSabinStep(const PolygonMesh& mesh) {
  const Corners corners(mesh);
  PolygonMesh out;
  out.positions = refinedValues(mesh, corners, mesh.positions);
  if (!mesh.uvs.empty()) out.uvs = refinedValues(mesh, corners, mesh.uvs);
  // The new vertex at a corner has its number; those of boundary edges follow, two by two.
  std::vector<uint32_t> onBoundary(corners.count(), 0);
  uint32_t next = corners.count();
  for (uint32_t c = 0; c < corners.count(); ++c)
    if (corners.isBoundary(c)) {
      onBoundary[c] = next;
      next += 2;
    }
  out.vertices.reserve(4 * size_t(corners.count()));
  const auto add = [&](auto&&... vertices) {
    out.starts.push_back(static_cast<uint32_t>(out.vertices.size()));
    (out.vertices.push_back(vertices), ...);
  };
  for (size_t f = 0; f < mesh.faceCount(); ++f) {
    checkInterrupted();
    add();
    for (uint32_t c = mesh.starts[f]; c < mesh.starts[f + 1]; ++c) out.vertices.push_back(c);
  }
  for (uint32_t c = 0; c < corners.count(); ++c) {
    const uint32_t other = corners.opposite(c);
    if (other == NO_CORNER)
      add(onBoundary[c], onBoundary[c] + 1, corners.next(c), c);
    else if (c < other)
      add(corners.next(other), other, corners.next(c), c);
  }
  corners.forVertices([&](const std::vector<uint32_t>& around, bool isClosed) {
    if (isClosed && around.size() < 3) return; // the faces of the edges meet
    add();
    if (!isClosed) out.vertices.push_back(onBoundary[around.front()]);
    out.vertices.insert(out.vertices.end(), around.begin(), around.end());
    if (!isClosed) out.vertices.push_back(onBoundary[corners.previous(around.back())] + 1);
  });
  out.starts.push_back(static_cast<uint32_t>(out.vertices.size()));
  return out;
}

MeshData dooSabinSurface(PolygonMesh mesh, int levels) {
  for (int i = 0; i < levels; ++i) mesh = dooSabinStep(mesh);
  const Corners corners(mesh);
  MeshData out;
  for (uint32_t f = 0; f < mesh.faceCount(); ++f) { // the step keeps the centre of a face
    out.positions.push_back(centre(mesh, mesh.positions, f));
    if (!mesh.uvs.empty()) out.uvs.push_back(centre(mesh, mesh.uvs, f));
    out.normals.push_back(limitNormalOfFace(mesh, f));
  }
  const std::vector<Vec3d> inner = refinedValues(mesh, corners, mesh.positions); // one for each corner
  std::vector<uint32_t> middles(corners.count(), 0);
  for (uint32_t c = 0; c < corners.count(); ++c) {
    if (!corners.isBoundary(c)) continue;
    middles[c] = static_cast<uint32_t>(out.positions.size());
    const uint32_t a = corners.vertex(c), b = corners.vertex(corners.next(c));
    const Vec3d middle = 0.5 * (mesh.positions[a] + mesh.positions[b]);
    out.positions.push_back(middle);
    if (!mesh.uvs.empty()) out.uvs.push_back(0.5 * (mesh.uvs[a] + mesh.uvs[b]));
    out.normals.push_back(glm::cross(mesh.positions[b] - mesh.positions[a],
                                     0.5 * (inner[c] + inner[corners.next(c)]) - middle));
  }
  corners.forVertices([&](const std::vector<uint32_t>& around, bool isClosed) {
    std::vector<uint32_t> polygon;
    if (!isClosed) polygon.push_back(middles[around.front()]);
    for (const uint32_t c : around) polygon.push_back(corners.face(c));
    if (!isClosed) polygon.push_back(middles[corners.previous(around.back())]);
    for (size_t k = 2; k < polygon.size(); ++k)
      out.triangles.emplace_back(polygon[0], polygon[k - 1], polygon[k]);
  });
  return out;
}

} // namespace recurse
