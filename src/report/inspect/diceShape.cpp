/** @file
 * Dual contouring by rays, and tubes.
 */
#include "report/inspect/diceShape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace recurse {

namespace {

/** Cubes around a shape, and its surface in each of them. */
class RayGrid {
 public:
  RayGrid(const Shape& shape, int cells) : shape(shape) {
    // The offsets avoid edges in the planes and axes of symmetry of shapes.
    const Vec3d offset(0.371, 0.413, 0.457);
    const Bounds3f box = shape.bounds();
    const Vec3d extent = box.diagonal();
    size = std::max({extent.x, extent.y, extent.z}) / cells;
    if (!(size > 0) || !std::isfinite(size)) return;
    origin = Vec3d(box.lower) - size * (1.0 + offset);
    for (int axis = 0; axis < 3; ++axis) counts[axis] = int(std::ceil(extent[axis] / size)) + 3;
    for (uint32_t primitive = 0; primitive < shape.primitiveCount(); ++primitive)
      for (int axis = 0; axis < 3; ++axis) castAlong(primitive, axis);
    for (auto& [index, cube] : cubes) cube.place(origin + size * Vec3d(positionOf(index)), size);
  }

  std::vector<DicedTriangle> triangles() const {
    std::vector<DicedTriangle> out;
    out.reserve(2 * edges.size());
    for (const Edge& e : edges) {
      std::array<Vec3f, 4> corners;
      for (size_t k = 0; k < 4; ++k) corners[k] = Vec3f(cubes.at(e.cubes[k]).vertex);
      out.push_back({{corners[0], corners[1], corners[2]}, e.primitive, e.parameters});
      out.push_back({{corners[0], corners[2], corners[3]}, e.primitive, e.parameters});
    }
    return out;
  }

 private:
  struct Cube {
    std::vector<std::pair<Vec3d, Vec3d>> crossings; ///< points and normals
    Vec3d vertex{0};

    /** Places the vertex near the tangent planes of all crossings, within the cube. */
    void place(const Vec3d& lower, double size) {
      constexpr int STEPS = 12;
      for (const auto& [point, normal] : crossings) vertex += point / double(crossings.size());
      for (int i = 0; i < STEPS; ++i) {
        Vec3d move(0);
        for (const auto& [point, normal] : crossings) move += glm::dot(normal, point - vertex) * normal;
        vertex = glm::clamp(vertex + move / double(crossings.size()), lower, lower + size);
      }
    }
  };
  struct Edge {
    std::array<uint64_t, 4> cubes;
    uint32_t primitive;
    HitParameters parameters;
  };

  uint64_t indexOf(const glm::ivec3& at) const {
    return (uint64_t(at.z) * uint64_t(counts.y) + uint64_t(at.y)) * uint64_t(counts.x) + uint64_t(at.x);
  }
  glm::ivec3 positionOf(uint64_t index) const {
    const auto x = uint64_t(counts.x), y = uint64_t(counts.y);
    return {int(index % x), int(index / x % y), int(index / (x * y))};
  }

  /** Finds the crossings of a primitive with the edges along an axis. */
  void castAlong(uint32_t primitive, int axis) {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    const Bounds3f box = shape.bounds(primitive);
    const auto first = [&](int k) {
      return std::max(1, int(std::floor((double(box.lower[k]) - origin[k]) / size)));
    };
    const auto last = [&](int k) {
      return std::min(counts[k] - 1, int(std::ceil((double(box.upper[k]) - origin[k]) / size)));
    };
    for (int i = first(b); i <= last(b); ++i)
      for (int j = first(c); j <= last(c); ++j) {
        Vec3d start;
        start[axis] = double(box.lower[axis]) - 0.5 * size;
        start[b] = origin[b] + i * size;
        start[c] = origin[c] + j * size;
        cast(primitive, axis, Vec3f(start), double(box.upper[axis] - box.lower[axis]) + size, {i, j});
      }
  }

  void cast(uint32_t primitive, int axis, const Vec3f& start, double length, const std::array<int, 2>& line) {
    constexpr int MOST = 256; // crossings of a line
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    Vec3f direction(0);
    direction[axis] = 1;
    float tMin = 0;
    int edgeBefore = -1;
    for (int k = 0; k < MOST; ++k) {
      const auto hit = shape.intersect(primitive, start, direction, tMin, static_cast<float>(length));
      if (!hit) return;
      tMin = hit->t + static_cast<float>(1e-4 * size);
      const SurfacePoint at = shape.placeAt(primitive, hit->parameters);
      Vec3d point(start);
      point[axis] += double(hit->t);
      glm::ivec3 cube;
      cube[axis] = std::clamp(int(std::floor((point[axis] - origin[axis]) / size)), 0, counts[axis] - 1);
      Edge edge{{}, primitive, hit->parameters};
      for (size_t corner = 0; corner < 4; ++corner) { // in the order of a closed polygon
        cube[b] = line[0] - int(corner == 0 || corner == 3);
        cube[c] = line[1] - int(corner < 2);
        edge.cubes[corner] = indexOf(cube);
        cubes[edge.cubes[corner]].crossings.emplace_back(point, Vec3d(at.geometricNormal));
      }
      if (cube[axis] != edgeBefore) edges.push_back(edge);
      edgeBefore = cube[axis];
    }
  }

  const Shape& shape;
  Vec3d origin{0};
  double size = 0;
  glm::ivec3 counts{0};
  std::unordered_map<uint64_t, Cube> cubes;
  std::vector<Edge> edges;
};

} // namespace

std::vector<DicedTriangle> dicedByRays(const Shape& shape, int cells) {
  return RayGrid(shape, cells).triangles();
}

std::vector<DicedTriangle> dicedCurve(const CurveShape& curve, uint32_t segment, const CurveDicing& dicing,
                                      float widening) {
  const glm::vec4* p = &curve.controls()[4 * size_t(segment)];
  const bool isRibbon = dicing.sides == 1;
  const uint32_t corners = isRibbon ? 2 : dicing.sides;
  std::vector<DicedTriangle> out;
  std::vector<Vec3f> before(corners), now(corners);
  Vec3f across(0);
  for (uint32_t i = 0; i <= dicing.pieces; ++i) {
    const float u = float(i) / float(dicing.pieces), v = 1 - u;
    const glm::vec4 at = v * v * v * p[0] + 3 * u * v * v * p[1] + 3 * u * u * v * p[2] + u * u * u * p[3];
    Vec3f along(v * v * (p[1] - p[0]) + 2 * u * v * (p[2] - p[1]) + u * u * (p[3] - p[2]));
    if (!(glm::length(along) > 0)) along = Vec3f(p[3] - p[0]);
    if (!(glm::length(along) > 0)) along = Vec3f(0, 0, 1);
    along = glm::normalize(along);
    // The frame of the piece before, turned as little as possible.
    across -= along * glm::dot(across, along);
    if (!(glm::length(across) > 1e-3f))
      across = glm::cross(along, std::abs(along.x) < 0.5f ? Vec3f(1, 0, 0) : Vec3f(0, 1, 0));
    across = glm::normalize(across);
    const Vec3f other = glm::cross(along, across);
    for (uint32_t k = 0; k < corners; ++k) {
      const float angle = 2 * PI * float(k) / float(corners);
      now[k] = Vec3f(at) + widening * at.w * (std::cos(angle) * across + std::sin(angle) * other);
    }
    if (i > 0) {
      const HitParameters middle(Vec2f((float(i) - 0.5f) / float(dicing.pieces), 0), other);
      for (uint32_t k = 0; k < dicing.sides; ++k) {
        const uint32_t next = (k + 1) % corners;
        out.push_back({{before[k], before[next], now[next]}, segment, middle});
        out.push_back({{before[k], now[next], now[k]}, segment, middle});
      }
    }
    std::swap(before, now);
  }
  return out;
}

} // namespace recurse
