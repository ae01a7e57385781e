/** @file
 * Bicubic Bézier patches, cut into triangles whose corners lie on the surface with its normals.
 */
#include <array>

#include "recurse/core/threads/resources.h"
#include "recurse/model/mesh/triangleMesh.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

constexpr size_t POINTS = 16; ///< control points of a patch, four rows of four

/** Bernstein polynomials of degree 3, and their derivatives. */
std::array<double, 4> weights(double t) {
  const double s = 1 - t;
  return {s * s * s, 3 * t * s * s, 3 * t * t * s, t * t * t};
}
std::array<double, 4> slopes(double t) {
  const double s = 1 - t;
  return {-3 * s * s, 3 * s * (s - 2 * t), 3 * t * (2 * s - t), 3 * t * t};
}

/** Weighted sum of the control points; u runs along the rows, v from row to row. */
Vec3d sum(const Vec3d* points, const std::array<double, 4>& alongU, const std::array<double, 4>& alongV) {
  Vec3d out(0);
  for (size_t row = 0; row < 4; ++row)
    for (size_t column = 0; column < 4; ++column)
      out += alongU[column] * alongV[row] * points[4 * row + column];
  return out;
}

Vec3d normalAt(const Vec3d* points, double u, double v) {
  return glm::cross(sum(points, slopes(u), weights(v)), sum(points, weights(u), slopes(v)));
}

void addPatch(const Vec3d* points, uint32_t steps, MeshData& mesh) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  double largest = 0; // longest normal, the scale of degenerate normals
  for (uint32_t j = 0; j <= steps; ++j)
    for (uint32_t i = 0; i <= steps; ++i) {
      const double u = double(i) / steps, v = double(j) / steps;
      mesh.positions.push_back(sum(points, weights(u), weights(v)));
      mesh.normals.push_back(normalAt(points, u, v));
      mesh.uvs.emplace_back(u, v);
      largest = std::max(largest, glm::length(mesh.normals.back()));
    }
  for (uint32_t j = 0; j <= steps; ++j)
    for (uint32_t i = 0; i <= steps; ++i) {
      Vec3d& normal = mesh.normals[first + j * (steps + 1) + i];
      if (glm::length(normal) > 1e-9 * largest) continue;
      // Where a side of the patch is a single point, the normal of a nearby point is used.
      const auto inside = [](double t) { return 1e-4 + (1 - 2e-4) * t; };
      normal = normalAt(points, inside(double(i) / steps), inside(double(j) / steps));
    }
  for (uint32_t j = 0; j < steps; ++j)
    for (uint32_t i = 0; i < steps; ++i) {
      const uint32_t a = first + j * (steps + 1) + i, b = a + steps + 1;
      mesh.triangles.emplace_back(a, a + 1, b + 1);
      mesh.triangles.emplace_back(a, b + 1, b);
    }
}

std::unique_ptr<Shape> makeBezierPatch(const Parameters& p, const ShapeContext& context) {
  const std::vector<Vec3d> points = p.vector3s("P");
  if (points.empty() || points.size() % POINTS != 0)
    p.fail("P", std::to_string(points.size()) + " points do not form patches",
           "16 for each patch, row by row");
  const auto steps = static_cast<uint32_t>(p.integer("steps"));
  constexpr double MOST_TRIANGLES = 1e8, TRIANGLE_SECONDS = 1e-6;
  const double triangles = 2.0 * steps * steps * double(points.size() / POINTS);
  if (triangles > MOST_TRIANGLES)
    p.fail("steps", "that makes more than " + std::to_string(int(MOST_TRIANGLES)) + " triangles",
           "fewer steps");
  requireWork("cutting sides into " + std::to_string(steps) + " pieces", TRIANGLE_SECONDS * triangles);
  MeshData mesh;
  for (size_t i = 0; i < points.size(); i += POINTS) addPatch(&points[i], steps, mesh);
  try {
    return std::make_unique<TriangleMesh>(std::move(mesh), context);
  } catch (const Error& e) {
    p.fail("P", e.what());
  }
}

} // namespace

void registerBezierPatch(PlugIns& plugIns) {
  plugIns.shapes.add(
      {{.name = "bezierpatch",
        .summary = "Bicubic Bézier patches. u runs along the rows, v from row to row; the outside is the "
                   "direction of their cross product.",
        .parameters = {arrayParameter(ParameterType::POINT3, "P", 0, "",
                                      "control points: 16 for each patch, four rows of four")
                           .require(),
                       integerParameter("steps", "16", "number of pieces along each side").range(1, 512)},
        .examples = {"\"integer steps\" 4 \"point3 P\" [0 0 0 1 0 1 2 0 1 3 0 0  0 1 0 1 1 2 2 1 2 3 1 0 "
                     "0 2 0 1 2 2 2 2 2 3 2 0  0 3 0 1 3 1 2 3 1 3 3 0]"}},
       makeBezierPatch});
}

} // namespace recurse
