/** @file
 * Displacement of triangle meshes (Cook, Carpenter, Catmull, "The Reyes Image Rendering Architecture", 1987:
 * dice to the size of a pixel, then displace).
 */
#include "recurse/model/mesh/displacement.h"

#include <unordered_map>

#include "recurse/core/io/text.h"
#include "recurse/core/threads/interrupt.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/core/threads/resources.h"
#include "recurse/model/texture/texture.h"

namespace recurse {

namespace {

/** Memory of a triangle before it is rendered [bytes], and time to make it [s]. */
constexpr double TRIANGLE_BYTES = 180, TRIANGLE_SECONDS = 3e-6;
constexpr size_t MAX_TRIANGLES = 20'000'000;

/** Corner k mod 3 of a triangle. */
uint32_t cornerAt(const glm::uvec3& t, uint32_t k) { return t[static_cast<int>(k % 3)]; }

class Displacement {
 public:
  Displacement(MeshData&& mesh, const TexturedRgb& height, double edgeLength, const ShapeContext& context)
      : height(height), fixedLength(edgeLength), context(context), active(std::move(mesh.triangles)) {
    weld(mesh);
    findDirections(mesh);
    move(0);
  }

  /** Divides all long edges. False where that would take more than MAX_TRIANGLES triangles. */
  bool divide() {
    constexpr int MAX_LEVELS = 64; // in double precision no edge is split more often
    size_t triangles = 0;
    for (int level = 0; level < MAX_LEVELS && !active.empty(); ++level) {
      findLongEdges();
      size_t count = done.size();
      for (const glm::uvec3& t : active) count += 1 + static_cast<size_t>(longEdgesOf(t));
      if (count > MAX_TRIANGLES) return false;
      requireWork(formatted("a surface of %zu triangles", count),
                  TRIANGLE_SECONDS * double(count - triangles));
      triangles = count;
      const size_t before = vertices.size();
      splitLongEdges();
      move(before);
    }
    return true;
  }

  MeshData result() {
    MeshData mesh;
    mesh.triangles = std::move(done);
    mesh.triangles.insert(mesh.triangles.end(), active.begin(), active.end());
    std::vector<Vec3d> normals(points.size(), Vec3d(0));
    for (const glm::uvec3& t : mesh.triangles) {
      const Vec3d& a = points[vertices[t.x].point].moved;
      const Vec3d n =
          glm::cross(points[vertices[t.y].point].moved - a, points[vertices[t.z].point].moved - a);
      for (int k = 0; k < 3; ++k) normals[vertices[t[k]].point] += n;
    }
    mesh.positions.reserve(vertices.size());
    mesh.normals.reserve(vertices.size());
    for (const Vertex& v : vertices) {
      const Point& p = points[v.point];
      mesh.positions.push_back(p.moved);
      const Vec3d& n = normals[v.point];
      mesh.normals.push_back(windsBackwards ? -n : n);
      if (hasUvs) mesh.uvs.push_back(v.uv);
    }
    return mesh;
  }

 private:
  /** A point of the surface. Along a seam of texture coordinates, several vertices share it. */
  struct Point {
    Vec3d flat, moved, direction;
  };
  struct Vertex {
    uint32_t point;
    Vec2d uv;
  };
  static constexpr uint32_t NONE = UINT32_MAX, UNNUMBERED = NONE - 1;
  using EdgeMap = std::unordered_map<uint64_t, uint32_t>;
  static uint64_t edgeKey(uint32_t a, uint32_t b) { return uint64_t(std::min(a, b)) << 32 | std::max(a, b); }

  void weld(const MeshData& mesh) {
    struct Hash {
      size_t operator()(const Vec3d& v) const {
        return static_cast<size_t>(std::bit_cast<uint64_t>(v.x) * 0x9e3779b97f4a7c15 ^
                                   std::bit_cast<uint64_t>(v.y) * 0xc2b2ae3d27d4eb4f ^
                                   std::bit_cast<uint64_t>(v.z) * 0x165667b19e3779f9);
      }
    };
    std::unordered_map<Vec3d, uint32_t, Hash> known;
    hasUvs = !mesh.uvs.empty();
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
      const Vec3d position = mesh.positions[i] + Vec3d(0); // -0 becomes 0, so that both hash alike
      const auto [found, isNew] = known.emplace(position, static_cast<uint32_t>(points.size()));
      if (isNew) points.push_back({position, position, Vec3d(0)});
      vertices.push_back({found->second, hasUvs ? mesh.uvs[i] : Vec2d(0)});
    }
  }

  /** Sets the directions of displacement: vertex normals, or else face normals weighted by angle. */
  void findDirections(const MeshData& mesh) {
    double agreement = 0; // between winding and normals: sum of their dot products
    for (const glm::uvec3& t : active) {
      Vec3d corner[3];
      for (int k = 0; k < 3; ++k) corner[k] = points[vertices[t[k]].point].flat;
      const Vec3d n = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
      const double length = glm::length(n);
      if (!(length > 0)) continue;
      for (uint32_t k = 0; k < 3; ++k) {
        if (!mesh.normals.empty()) {
          agreement += glm::dot(n, mesh.normals[t[static_cast<int>(k)]]);
          continue;
        }
        const Vec3d a = glm::normalize(corner[(k + 1) % 3] - corner[k]),
                    b = glm::normalize(corner[(k + 2) % 3] - corner[k]);
        points[vertices[cornerAt(t, k)].point].direction +=
            n / length * std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
      }
    }
    for (size_t i = 0; i < mesh.normals.size(); ++i)
      if (glm::length(mesh.normals[i]) > 0)
        points[vertices[i].point].direction += glm::normalize(mesh.normals[i]);
    for (Point& p : points)
      if (const double length = glm::length(p.direction); length > 0) p.direction /= length;
    windsBackwards = agreement < 0;
  }

  double heightAt(const Vertex& v) const {
    const Point& p = points[v.point];
    SurfacePoint s;
    s.position = Vec3f(transformPoint(context.sceneFromObject, p.flat) + context.textureShift);
    s.uv = Vec2f(v.uv);
    s.geometricNormal = s.shadingNormal = Vec3f(p.direction);
    s.dpdu = s.dpdv = Vec3f(0);
    return double(height.at(s).r);
  }

  /** Displaces the points of the vertices from `first` on; on a seam, by the mean height of its sides. */
  void move(size_t first) {
    constexpr size_t BLOCK = 4096;
    std::vector<double> heights(vertices.size() - first);
    parallelFor((heights.size() + BLOCK - 1) / BLOCK, [&](size_t block) {
      for (size_t i = block * BLOCK; i < std::min(heights.size(), (block + 1) * BLOCK); ++i)
        heights[i] = heightAt(vertices[first + i]);
    });
    const uint32_t firstPoint = first == 0 ? 0 : firstNewPoint;
    std::vector<std::pair<double, int>> sums(points.size() - firstPoint);
    for (size_t i = 0; i < heights.size(); ++i) {
      if (!std::isfinite(heights[i])) throw Error("the displacement has values that are not finite");
      auto& [sum, count] = sums[vertices[first + i].point - firstPoint];
      sum += heights[i];
      ++count;
    }
    for (size_t i = 0; i < sums.size(); ++i) {
      Point& p = points[firstPoint + i];
      if (sums[i].second > 0) p.moved = p.flat + p.direction * (sums[i].first / sums[i].second);
    }
  }

  /** True where an edge must be split: it is longer than the limit with or without displacement. At a jump of
   * the displacement, STEEPEST ends the division. */
  bool isLong(const Point& a, const Point& b) const {
    constexpr double STEEPEST = 2;
    const Mat4d& m = context.sceneFromObject;
    const Vec3d from = transformPoint(m, a.moved), to = transformPoint(m, b.moved);
    const double limit = fixedLength > 0 ? fixedLength : context.dicing->edgeLength(from, to);
    const double flat = glm::length(transformVector(m, b.flat - a.flat));
    return std::max(flat, glm::length(to - from)) > limit && flat * STEEPEST > limit;
  }

  void findLongEdges() {
    middlePoints.clear();
    for (const glm::uvec3& t : active) {
      checkInterrupted();
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t a = vertices[cornerAt(t, k)].point, b = vertices[cornerAt(t, k + 1)].point;
        const auto [found, isNew] = middlePoints.emplace(edgeKey(a, b), NONE);
        if (isNew && a != b && isLong(points[std::min(a, b)], points[std::max(a, b)]))
          found->second = UNNUMBERED;
      }
    }
  }
  bool isSplit(uint32_t va, uint32_t vb) const {
    return middlePoints.at(edgeKey(vertices[va].point, vertices[vb].point)) != NONE;
  }
  int longEdgesOf(const glm::uvec3& t) const {
    return isSplit(t.x, t.y) + isSplit(t.y, t.z) + isSplit(t.z, t.x);
  }

  void splitLongEdges() {
    firstNewPoint = static_cast<uint32_t>(points.size());
    for (const glm::uvec3& t : active)
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t ia = vertices[cornerAt(t, k)].point, ib = vertices[cornerAt(t, k + 1)].point;
        uint32_t& middle = middlePoints.at(edgeKey(ia, ib));
        if (middle != UNNUMBERED) continue;
        middle = static_cast<uint32_t>(points.size());
        const Point &a = points[ia], &b = points[ib];
        const Vec3d direction = a.direction + b.direction, flat = 0.5 * (a.flat + b.flat);
        const double length = glm::length(direction);
        points.push_back({flat, flat, length > 0 ? direction / length : a.direction});
      }
    EdgeMap middleVertices;
    const auto middleOf = [&](uint32_t va, uint32_t vb) {
      const auto [found, isNew] =
          middleVertices.emplace(edgeKey(va, vb), static_cast<uint32_t>(vertices.size()));
      if (isNew)
        vertices.push_back({middlePoints.at(edgeKey(vertices[va].point, vertices[vb].point)),
                            0.5 * (vertices[va].uv + vertices[vb].uv)});
      return found->second;
    };
    std::vector<glm::uvec3> next;
    for (const glm::uvec3& t : active) {
      checkInterrupted();
      const int count = longEdgesOf(t);
      if (count == 0) {
        done.push_back(t);
        continue;
      }
      if (count == 3) {
        const glm::uvec3 m(middleOf(t.x, t.y), middleOf(t.y, t.z), middleOf(t.z, t.x));
        next.insert(next.end(), {{t.x, m.x, m.z}, {m.x, t.y, m.y}, {m.z, m.y, t.z}, m});
        continue;
      }
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t a = cornerAt(t, k), b = cornerAt(t, k + 1), c = cornerAt(t, k + 2);
        if (isSplit(a, b) != (count == 1)) continue; // the one edge that differs
        if (count == 1) {
          const uint32_t m = middleOf(a, b);
          next.insert(next.end(), {{a, m, c}, {m, b, c}});
        } else {
          const uint32_t m = middleOf(b, c), n = middleOf(c, a);
          next.push_back({m, c, n});
          const auto apart = [&](uint32_t i, uint32_t j) {
            return glm::length(points[vertices[i].point].flat - points[vertices[j].point].flat);
          };
          if (apart(a, m) < apart(b, n))
            next.insert(next.end(), {{a, b, m}, {a, m, n}});
          else
            next.insert(next.end(), {{a, b, n}, {b, m, n}});
        }
        break;
      }
    }
    active.swap(next);
  }

  TexturedRgb height;
  double fixedLength; ///< length of edges [scene units]; 0: `context.dicing` decides
  const ShapeContext& context;
  std::vector<Point> points;
  std::vector<Vertex> vertices;
  std::vector<glm::uvec3> active, done; ///< vertex indices of triangles: perhaps divided further, and final
  EdgeMap middlePoints;                 ///< by edge between points; NONE: the edge is short
  uint32_t firstNewPoint = 0;
  bool hasUvs = false, windsBackwards = false;
};

/** Lower bound of the number of triangles of a mesh without edges longer than `edge` [scene units]: area of
 * the mesh over area of the equilateral triangle, the largest. */
double leastTriangles(const MeshData& mesh, const Mat4d& sceneFromObject, double edge) {
  double area = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const Vec3d& a = mesh.positions[t.x];
    area += 0.5 * glm::length(glm::cross(transformVector(sceneFromObject, mesh.positions[t.y] - a),
                                         transformVector(sceneFromObject, mesh.positions[t.z] - a)));
  }
  return area / (std::sqrt(3.0) / 4 * square(edge));
}

} // namespace

std::vector<ParameterSpec> withDisplacement(std::vector<ParameterSpec> own) {
  own.insert(
      own.end(),
      {realParameter(
           "displacement", "",
           "displacement of the surface along its normals, in the shape's own units; a texture, or a number")
           .withTexture(),
       realParameter("edgelength", "",
                     "maximum edge length of the displaced surface [scene units]; by default edges are "
                     "shorter than a pixel")
           .positive(),
       ignoredParameter(ParameterType::BOOLEAN, "uvdisplacement", "a setting of pbrt's displacement")});
  return own;
}

std::unique_ptr<TriangleMesh> makeDisplacedMesh(MeshData mesh, const Parameters& p,
                                                const ShapeContext& context) {
  if (!p.has("displacement")) {
    if (p.has("edgelength"))
      p.fail("edgelength", "there is no displacement", "\"texture displacement\" with it");
    return std::make_unique<TriangleMesh>(std::move(mesh), context);
  }
  const TexturedRgb height = realOrTexture(context.textures, p, "displacement");
  if (!p.has("edgelength") && !context.dicing)
    p.fail("displacement", "the maximum edge length is unknown", "\"float edgelength\"");
  const TriangleMesh checked(mesh, context); // validates the mesh; throws Error
  const double edge = p.has("edgelength") ? p.real("edgelength") : 0;
  if (edge > 0) {
    const double least = leastTriangles(mesh, context.sceneFromObject, edge);
    try {
      requireMemory(formatted("a surface of at least %.3g triangles", least), TRIANGLE_BYTES * least);
    } catch (const Error& e) {
      p.fail("edgelength", e.what(), "a larger length");
    }
  }
  Displacement displacement(std::move(mesh), height, edge, context);
  if (!displacement.divide())
    p.warn("displacement",
           "edges are longer than \"edgelength\": shorter edges would need more than " +
               std::to_string(MAX_TRIANGLES) + " triangles",
           "a larger \"edgelength\"");
  return std::make_unique<TriangleMesh>(displacement.result(), context);
}

} // namespace recurse
