/** @file
 * Edges of triangle meshes and rings of vertices around a vertex, for subdivision.
 */
#pragma once

#include <optional>
#include <unordered_map>

#include "recurse/core/threads/interrupt.h"
#include "recurse/model/mesh/triangleMesh.h"

namespace recurse {

/** Edges of a triangle mesh, and the neighbourhood of each vertex. */
class TriangleTopology {
 public:
  struct Edge {
    uint32_t a, b;        ///< vertices
    uint32_t opposite[2]; ///< third vertices of the one or two triangles
    int triangles = 0;
    bool isBoundary() const { return triangles == 1; }
  };

  /** Side of an edge: a triangle, and the number of the edge in it. */
  struct Side {
    uint32_t triangle, edge;
  };

  /** The triangles must outlive the topology. Throws Error where they are not a surface with an outside. */
  TriangleTopology(const std::vector<glm::uvec3>& triangles, size_t vertexCount)
      : edgesOf(vertexCount, 0), boundaryOf(vertexCount, 0), triangles(triangles) {
    for (uint32_t i = 0; i < triangles.size(); ++i) {
      checkInterrupted();
      const glm::uvec3& t = triangles[i];
      for (int k = 0; k < 3; ++k) {
        const uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
        if (!directed.emplace(key(a, b), Side{i, static_cast<uint32_t>(k)}).second)
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

  const Edge& edge(uint32_t a, uint32_t b) const { return edges[edgeNumber(a, b)]; }
  size_t edgeNumber(uint32_t a, uint32_t b) const { return numbers.at(key(std::min(a, b), std::max(a, b))); }
  /** Side of the edge on which a triangle has it from a to b; null where there is none. */
  const Side* side(uint32_t a, uint32_t b) const {
    const auto found = directed.find(key(a, b));
    return found == directed.end() ? nullptr : &found->second;
  }
  /** Vertex after `from` around `v`: the third vertex of the triangle v, from, ...; empty at the boundary. */
  std::optional<uint32_t> next(uint32_t v, uint32_t from) const {
    const Side* s = side(v, from);
    return s ? std::optional(triangles[s->triangle][(s->edge + 2) % 3]) : std::nullopt;
  }

  std::vector<Edge> edges;
  std::vector<uint32_t> edgesOf, boundaryOf; ///< numbers of edges, and of boundary edges, at a vertex

 private:
  static uint64_t key(uint32_t a, uint32_t b) { return uint64_t(a) << 32 | b; }
  const std::vector<glm::uvec3>& triangles;
  std::unordered_map<uint64_t, size_t> numbers;
  std::unordered_map<uint64_t, Side> directed;
};

/** Neighbours in order around a vertex; on the boundary, from its first boundary edge to its last. */
inline std::vector<uint32_t> ringAround(const TriangleTopology& t, uint32_t v, uint32_t any) {
  std::vector<uint32_t> ring{any};
  if (t.boundaryOf[v] > 0) { // back to the first, which has no predecessor
    for (uint32_t steps = 0; steps < t.edgesOf[v]; ++steps) {
      // The triangle v, x, ring.front() is also ring.front(), v, x.
      const auto before = t.next(ring.front(), v);
      if (!before) break;
      ring.front() = *before;
    }
  }
  while (ring.size() < t.edgesOf[v]) {
    const auto after = t.next(v, ring.back());
    if (!after) break;
    ring.push_back(*after);
  }
  return ring;
}

/** Normal of the limit surface of Loop, inside also of √3, from the ring around a vertex (Hoppe et al.,
 * "Piecewise Smooth Surface Reconstruction", 1994). As in pbrt-v4, triangles are clockwise as seen from the
 * outside. */
inline Vec3d limitNormal(const Vec3d& v, const std::vector<Vec3d>& ring, bool onBoundary) {
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

} // namespace recurse
