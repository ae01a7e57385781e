/** @file
 * Tessellation of shapes, and simplification by a grid whose cells grow with the distance from the camera.
 */
#include "report/inspect/sceneMesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <unordered_map>
#include <unordered_set>

#include "recurse/core/sampling/sampler.h"
#include "recurse/model/mesh/triangleMesh.h"
#include "recurse/model/scene/placedShapes.h"
#include "report/inspect/diceShape.h"

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

/** Look of a surface in the view. */
struct Look {
  Rgb albedo; ///< at normal incidence
  bool isSpecular = false;
};

Look lookAt(const PlacedShape& placed, const Material* material, const SurfacePoint& point) {
  constexpr float CLEAR = 0.85f; // grey of mirrors and glass, which have no albedo
  if (placed.emits) return {Rgb(1, 0.9f, 0.6f)};
  if (!material) return {Rgb(CLEAR), true};
  BsdfArena arena;
  const Bsdf* bsdf = material->bsdfAt(point, arena);
  if (!bsdf || !(bsdf->lobes() & NON_DELTA_LOBES)) return {Rgb(CLEAR), true};
  return {bsdf->albedo(Vec3f(0, 0, 1))};
}

/** Whether a shape has no faces of its own, and is no curve. */
bool needsRays(const Shape& shape) {
  return !shape.triangleMesh() && shape.faceCount() == 0 && !dynamic_cast<const CurveShape*>(&shape);
}

/** Resolution of the shapes without faces, by their number in a scene. */
struct DicingPlan {
  int cells = 0; ///< see dicedByRays()
  CurveDicing curve;
  size_t curveStride = 1; ///< one of so many curves is shown, and is wider

  DicingPlan(const Scene& scene, size_t limit) {
    constexpr double CUBE_TRIANGLES = 6; // a shape has about so many for each square of its cells
    constexpr double LEAST = 8, MOST = 96, MOST_OF_COSTLY = 48, COSTLY = 8; // the last in tests of a ray
    constexpr size_t CURVE_FRACTION = 2;                                    // of the limit
    size_t shapes = 0, segments = 0;
    double tests = 1;
    visitShapes(scene, [&](const PlacedShape& placed) {
      if (needsRays(*placed.shape)) {
        ++shapes;
        tests = std::max(tests, placed.shape->testsOfRay());
      }
      if (dynamic_cast<const CurveShape*>(placed.shape)) segments += placed.shape->primitiveCount();
    });
    const double squares = double(limit) / (CUBE_TRIANGLES * double(std::max<size_t>(shapes, 1)));
    cells = static_cast<int>(std::clamp(std::sqrt(squares), LEAST, tests > COSTLY ? MOST_OF_COSTLY : MOST));
    const size_t most = limit / CURVE_FRACTION;
    for (const CurveDicing& dicing : {CurveDicing{8, 4}, {6, 3}, {4, 1}, {2, 1}, {1, 1}}) {
      curve = dicing;
      if (segments * curve.triangles() <= most) return;
    }
    curveStride = (segments * curve.triangles() + most - 1) / std::max<size_t>(most, 1);
  }
};

class MeshMaker {
 public:
  MeshMaker(const Scene& scene, size_t limit) : scene(scene), plan(scene, limit) {}

  void add(const PlacedShape& placed) {
    object = objectOf(placed);
    if (const TriangleMesh* triangles = placed.shape->triangleMesh())
      addTriangles(placed, *triangles);
    else if (placed.shape->faceCount() > 0)
      addFaces(placed);
    else if (const auto* curve = dynamic_cast<const CurveShape*>(placed.shape))
      addCurve(placed, *curve);
    else
      addByRays(placed);
  }

  SceneMesh curves; ///< curves are too thin to be simplified by a grid
  SceneMesh mesh;

 private:
  uint16_t objectOf(const PlacedShape& placed) {
    const auto [found, isNew] = objects.try_emplace(placed.object, mesh.names.size());
    if (isNew && mesh.names.size() < MOST_OBJECTS) mesh.names.push_back(scene.objectName(placed.object));
    return static_cast<uint16_t>(std::min(found->second, mesh.names.size() - 1));
  }

  void addTriangle(const PlacedShape& placed, const std::array<Vec3f, 3>& corners, const Look& look) {
    addTriangle(placed, corners, look, mesh);
  }
  void addTriangle(const PlacedShape& placed, const std::array<Vec3f, 3>& corners, const Look& look,
                   SceneMesh& to) {
    for (const Vec3f& corner : corners) {
      const Vec3f p(transformPoint(placed.sceneFromShape, corner));
      to.positions.insert(to.positions.end(), {p.x, p.y, p.z});
    }
    for (int c = 0; c < 3; ++c) to.colours.push_back(srgb(look.albedo[c]));
    to.specular.push_back(look.isSpecular);
    to.objects.push_back(object);
    ++to.before;
  }

  void addTriangles(const PlacedShape& placed, const TriangleMesh& triangles) {
    for (uint32_t i = 0; i < triangles.primitiveCount(); ++i) {
      const glm::uvec3& index = triangles.indices()[i];
      const auto& p = triangles.positions();
      addTriangle(placed, {p[index.x], p[index.y], p[index.z]},
                  lookAt(placed, placed.material, triangles.surfaceAt(i, HitParameters(Vec2f(1.0f / 3)))));
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
          const Look look = lookAt(placed, placed.material, at(face, i + 0.5, j + 0.5));
          addTriangle(placed, {a, b, c}, look);
          addTriangle(placed, {a, c, d}, look);
        }
  }

  void addDiced(const PlacedShape& placed, const std::vector<DicedTriangle>& triangles, SceneMesh& to) {
    const bool isCompound = !placed.shape->componentMaterials().empty();
    for (const DicedTriangle& t : triangles) {
      const Material* material = isCompound ? placed.shape->materialAt(t.parameters) : placed.material;
      addTriangle(placed, t.corners,
                  lookAt(placed, material, placed.shape->surfaceAt(t.primitive, t.parameters)), to);
    }
  }

  void addByRays(const PlacedShape& placed) {
    const auto [found, isNew] = sampled.try_emplace(placed.shape);
    if (isNew) found->second = dicedByRays(*placed.shape, plan.cells);
    addDiced(placed, found->second, mesh);
    ++mesh.sampledShapes;
  }

  /** Adds all segments of a curve, or none, where a stride leaves some out; curves of many segments are
   * bundles, of which single segments are left out. */
  void addCurve(const PlacedShape& placed, const CurveShape& curve) {
    constexpr uint32_t BUNDLE = 64;
    constexpr size_t WIDEST = 8;
    const size_t stride = plan.curveStride;
    const uint32_t count = curve.primitiveCount();
    const auto widening = static_cast<float>(std::min(stride, WIDEST));
    const uint64_t number = curveNumber++;
    mesh.curves += count;
    for (uint32_t segment = 0; segment < count; ++segment) {
      if (hashCombine(number, count > BUNDLE ? segment : 0) % stride != 0) continue;
      addDiced(placed, dicedCurve(curve, segment, plan.curve, widening), curves);
      ++mesh.shownCurves;
    }
  }

  const Scene& scene;
  const DicingPlan plan;
  std::map<uint32_t, size_t> objects;
  std::map<const Shape*, std::vector<DicedTriangle>> sampled;
  uint64_t curveNumber = 0;
  uint16_t object = 0;
};

/** Size of things in the camera's picture: distance from the camera, times a factor outside of its view. */
class ViewScale {
 public:
  explicit ViewScale(const Scene& scene) : radius(scene.bounds().radius) {
    const PixelBounds& crop = scene.film().crop;
    const auto x0 = float(crop.x0), x1 = float(crop.x1), y0 = float(crop.y0), y1 = float(crop.y1);
    const auto middle = scene.camera().validRay({Vec2f((x0 + x1) / 2, (y0 + y1) / 2)});
    if (!middle) return;
    eye = middle->origin;
    direction = glm::normalize(middle->direction);
    hasEye = true;
    for (const Vec2f& film : {Vec2f(x0, y0), Vec2f(x1, y0), Vec2f(x1, y1), Vec2f(x0, y1)}) {
      const auto ray = scene.camera().validRay({film});
      hasEye = hasEye && ray && glm::length(ray->origin - eye) < 0.01f * radius;
      if (ray) cosine = std::min(cosine, glm::dot(glm::normalize(ray->direction), direction));
    }
  }

  /** Power of two next to the scale of a point. */
  int level(const float* p) const {
    constexpr float OUTSIDE = 4, NEAREST = 1e-5f;
    if (!hasEye) return 0;
    const Vec3f d = Vec3f(p[0], p[1], p[2]) - eye;
    const float distance = std::max(glm::length(d), NEAREST * radius);
    const bool isSeen = glm::dot(d, direction) >= cosine * distance;
    return std::ilogb(distance / radius * (isSeen ? 1 : OUTSIDE));
  }

 private:
  float radius;
  Vec3f eye{0}, direction{0};
  float cosine = 1; ///< of the largest angle to the direction in the view
  bool hasEye = false;
};

/** Mesh with all vertices of a grid cell merged into one of them, without degenerate and equal triangles.
 * `cellSize`: at the distance of a scene radius [scene units]. */
SceneMesh simplified(const SceneMesh& mesh, const ViewScale& scale, double cellSize) {
  std::unordered_map<uint64_t, const float*> representatives;
  std::unordered_set<uint64_t> triangles;
  triangles.reserve(mesh.triangles() / 2);
  representatives.reserve(mesh.triangles() / 4);
  SceneMesh out{{}, {}, {}, {}, mesh.names, mesh.before, mesh.sampledShapes, mesh.curves, mesh.shownCurves};
  for (size_t t = 0; t < mesh.triangles(); ++t) {
    std::array<uint64_t, 3> cells;
    std::array<const float*, 3> corners;
    for (size_t k = 0; k < 3; ++k) {
      const float* p = &mesh.positions[9 * t + 3 * k];
      const int level = scale.level(p);
      const double size = std::ldexp(cellSize, level);
      cells[k] = uint64_t(level);
      for (size_t axis = 0; axis < 3; ++axis)
        cells[k] = hashCombine(cells[k], uint64_t(std::llround(std::floor(double(p[axis]) / size))));
      corners[k] = representatives.try_emplace(cells[k], p).first->second;
    }
    if (cells[0] == cells[1] || cells[1] == cells[2] || cells[0] == cells[2]) continue;
    std::array<uint64_t, 3> sorted = cells;
    std::sort(sorted.begin(), sorted.end());
    if (!triangles.insert(hashCombine(hashCombine(sorted[0], sorted[1]), sorted[2])).second) continue;
    for (const float* c : corners) out.positions.insert(out.positions.end(), c, c + 3);
    out.colours.insert(out.colours.end(), &mesh.colours[3 * t], &mesh.colours[3 * t] + 3);
    out.objects.push_back(mesh.objects[t]);
    out.specular.push_back(mesh.specular[t]);
  }
  return out;
}

/** Simplifies a mesh to at most a number of triangles, and not much fewer. `cellSize`: first to try; becomes
 * the one that was used. */
void simplifyTo(size_t most, const ViewScale& scale, double& cellSize, SceneMesh& mesh) {
  constexpr double COARSER = 2.5;
  constexpr int STEPS = 5; // of a bisection
  while (mesh.triangles() > most) {
    SceneMesh coarser = simplified(mesh, scale, cellSize);
    if (coarser.triangles() > most) {
      mesh = std::move(coarser);
      cellSize *= COARSER;
      continue;
    }
    double fine = cellSize / COARSER, coarse = cellSize;
    for (int i = 0; i < STEPS; ++i) {
      const double middle = std::sqrt(fine * coarse);
      SceneMesh tried = simplified(mesh, scale, middle);
      const bool fits = tried.triangles() <= most;
      (fits ? coarse : fine) = middle;
      if (fits) coarser = std::move(tried);
    }
    cellSize = coarse;
    mesh = std::move(coarser);
  }
}

/** Appends the triangles of a mesh with the same names. */
void append(const SceneMesh& more, SceneMesh& mesh) {
  mesh.positions.insert(mesh.positions.end(), more.positions.begin(), more.positions.end());
  mesh.colours.insert(mesh.colours.end(), more.colours.begin(), more.colours.end());
  mesh.objects.insert(mesh.objects.end(), more.objects.begin(), more.objects.end());
  mesh.specular.insert(mesh.specular.end(), more.specular.begin(), more.specular.end());
  mesh.before += more.before;
}

} // namespace

SceneMesh meshOf(const Scene& scene, size_t limit) {
  constexpr double FINEST = 1.0 / 8192; // cell at the distance of the scene's radius [radii]
  constexpr size_t HELD = 20;           // times the limit, in memory at once
  MeshMaker maker(scene, limit);
  SceneMesh& mesh = maker.mesh;
  const ViewScale scale(scene);
  double cell = FINEST * double(scene.bounds().radius);
  visitShapes(scene, [&](const PlacedShape& placed) {
    maker.add(placed);
    simplifyTo(HELD * limit, scale, cell, mesh);
  });
  simplifyTo(limit - std::min(limit, maker.curves.triangles()), scale, cell, mesh);
  append(maker.curves, mesh);
  return std::move(mesh);
}

} // namespace recurse
