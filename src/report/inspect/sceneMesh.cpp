/** @file
 * Tessellation of shapes, and simplification by a grid.
 */
#include "report/inspect/sceneMesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "recurse/model/mesh/triangleMesh.h"
#include "recurse/model/scene/placedShapes.h"

namespace recurse {

namespace {

/** Pieces along each side of a face; faces of shapes with more than MANY_FACES faces stay whole. */
constexpr uint32_t PIECES = 24;
constexpr uint32_t MANY_FACES = 256;
constexpr size_t MOST_OBJECTS = 65536;

uint8_t srgb(float linear) {
  const double x = std::clamp(double(linear), 0.0, 1.0);
  return static_cast<uint8_t>(
      std::lround(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055)));
}

/** Colour of a surface in the view: its albedo at normal incidence. */
Rgb albedoAt(const PlacedShape& placed, const SurfacePoint& point) {
  constexpr float CLEAR = 0.85f; // grey of mirrors and glass, which have no albedo
  if (placed.emits) return Rgb(1, 0.9f, 0.6f);
  if (!placed.material) return Rgb(CLEAR);
  BsdfArena arena;
  const Bsdf* bsdf = placed.material->bsdfAt(point, arena);
  if (!bsdf || !(bsdf->lobes() & NON_DELTA_LOBES)) return Rgb(CLEAR);
  return bsdf->albedo(Vec3f(0, 0, 1));
}

class MeshMaker {
 public:
  explicit MeshMaker(const Scene& scene) : scene(scene) {}

  void add(const PlacedShape& placed) {
    object = objectOf(placed);
    if (const TriangleMesh* triangles = placed.shape->triangleMesh())
      addTriangles(placed, *triangles);
    else if (placed.shape->faceCount() > 0)
      addFaces(placed);
    else
      addBox(placed);
  }

  SceneMesh mesh;

 private:
  uint16_t objectOf(const PlacedShape& placed) {
    const auto [found, isNew] = objects.try_emplace(placed.object, mesh.names.size());
    if (isNew && mesh.names.size() < MOST_OBJECTS) mesh.names.push_back(scene.objectName(placed.object));
    return static_cast<uint16_t>(std::min(found->second, mesh.names.size() - 1));
  }

  void addTriangle(const PlacedShape& placed, const std::array<Vec3f, 3>& corners, const Rgb& colour) {
    for (const Vec3f& corner : corners) {
      const Vec3f p(transformPoint(placed.sceneFromShape, corner));
      mesh.positions.insert(mesh.positions.end(), {p.x, p.y, p.z});
    }
    for (int c = 0; c < 3; ++c) mesh.colours.push_back(srgb(colour[c]));
    mesh.objects.push_back(object);
    ++mesh.before;
  }

  void addTriangles(const PlacedShape& placed, const TriangleMesh& triangles) {
    for (uint32_t i = 0; i < triangles.primitiveCount(); ++i) {
      const glm::uvec3& index = triangles.indices()[i];
      const auto& p = triangles.positions();
      addTriangle(placed, {p[index.x], p[index.y], p[index.z]},
                  albedoAt(placed, triangles.surfaceAt(i, HitParameters(Vec2f(1.0f / 3)))));
    }
  }

  void addFaces(const PlacedShape& placed) {
    const Shape& shape = *placed.shape;
    const uint32_t n = std::max(1u, shape.faceCount() > MANY_FACES ? 1u : PIECES);
    const auto at = [&](uint32_t face, double i, double j) {
      return shape.pointOnFace({face, Vec2d(i, j) / double(n)});
    };
    for (uint32_t face = 0; face < shape.faceCount(); ++face)
      for (uint32_t i = 0; i < n; ++i)
        for (uint32_t j = 0; j < n; ++j) {
          const Vec3f a = at(face, i, j).position, b = at(face, i + 1, j).position,
                      c = at(face, i + 1, j + 1).position, d = at(face, i, j + 1).position;
          const Rgb colour = albedoAt(placed, at(face, i + 0.5, j + 0.5));
          addTriangle(placed, {a, b, c}, colour);
          addTriangle(placed, {a, c, d}, colour);
        }
  }

  void addBox(const PlacedShape& placed) {
    const Bounds3f local = placed.shape->bounds();
    Bounds3f box;
    for (int k = 0; k < 8; ++k) {
      const Vec3d corner(k & 1 ? local.upper.x : local.lower.x, k & 2 ? local.upper.y : local.lower.y,
                         k & 4 ? local.upper.z : local.lower.z);
      box.add(Vec3f(transformPoint(placed.sceneFromShape, corner)));
    }
    mesh.boxes.push_back(box);
  }

  const Scene& scene;
  std::map<uint32_t, size_t> objects;
  uint16_t object = 0;
};

using Cell = std::array<int64_t, 3>;

/** Mesh with all vertices of a grid cell merged into one of them, without degenerate triangles. */
SceneMesh simplified(const SceneMesh& mesh, float cellSize) {
  std::map<Cell, Vec3f> representatives;
  SceneMesh out{{}, {}, {}, mesh.names, mesh.before, mesh.boxes};
  for (size_t t = 0; t < mesh.triangles(); ++t) {
    std::array<Cell, 3> cells;
    std::array<Vec3f, 3> corners;
    for (size_t k = 0; k < 3; ++k) {
      const float* p = &mesh.positions[9 * t + 3 * k];
      for (size_t axis = 0; axis < 3; ++axis)
        cells[k][axis] = std::llround(std::floor(double(p[axis]) / double(cellSize)));
      corners[k] = representatives.try_emplace(cells[k], p[0], p[1], p[2]).first->second;
    }
    if (cells[0] == cells[1] || cells[1] == cells[2] || cells[0] == cells[2]) continue;
    for (const Vec3f& c : corners) out.positions.insert(out.positions.end(), {c.x, c.y, c.z});
    out.colours.insert(out.colours.end(), &mesh.colours[3 * t], &mesh.colours[3 * t] + 3);
    out.objects.push_back(mesh.objects[t]);
  }
  return out;
}

} // namespace

SceneMesh meshOf(const Scene& scene, size_t limit) {
  constexpr float FINEST = 1.0f / 2048, COARSER = 1.5f; // fractions of the scene's radius
  constexpr size_t HELD = 20;                           // times the limit, in memory at once
  MeshMaker maker(scene);
  SceneMesh& mesh = maker.mesh;
  float cell = FINEST * scene.bounds().radius;
  const auto simplifyTo = [&](size_t most) {
    for (; mesh.triangles() > most; cell *= COARSER) mesh = simplified(mesh, cell);
  };
  visitShapes(scene, [&](const PlacedShape& placed) {
    maker.add(placed);
    simplifyTo(HELD * limit);
  });
  simplifyTo(limit);
  return std::move(mesh);
}

} // namespace recurse
