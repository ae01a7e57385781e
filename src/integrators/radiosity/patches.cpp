/** @file
 * Subdivision of shapes into patches.
 */
#include "integrators/radiosity/patches.h"

#include <algorithm>
#include <map>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/core/sampling/sampler.h"
#include "recurse/model/bsdf/bsdf.h"
#include "recurse/model/bsdf/surfaceDetail.h"
#include "recurse/model/mesh/triangleMesh.h"
#include "recurse/model/texture/texture.h"

namespace recurse {

namespace {

constexpr size_t MAX_PATCHES = 100000;
/** Approximate default number of patches; more result where they are not as wide as they are long. */
constexpr double DEFAULT_PATCHES = 10000;
constexpr double MAX_DIVISIONS = 128;
/** Maximum turn of the normal along the edge of a patch [rad]. */
constexpr double MAX_TURN = 0.5;
/** Number of coordinate lines, and of pieces of each, by which the length and turn of a face are measured. */
constexpr int LINES = 3, PIECES = 16;
/** Areas are sums over AREA_PIECES² triangles, with the opacity at their centroids. */
constexpr int AREA_PIECES = 4;
/** Maximum number of points to try until one is opaque. */
constexpr int MAX_TRIES = 64;

bool isMatt(const Material* material) {
  return material && (material->lobes() & (ALL_LOBES | LAMBERTIAN)) == (REFLECTION | LAMBERTIAN);
}

bool isCut(const SceneShape& s) {
  return isMatt(s.material) && s.shape->canBeSampled() && s.shape->componentMaterials().empty() &&
         (s.shape->triangleMesh() || s.shape->faceCount() > 0);
}

float opacity(const Shape& shape, const SurfacePoint& point) {
  return shape.alpha ? std::clamp(shape.alpha->at(point).r, 0.0f, 1.0f) : 1.0f;
}

Vec2d within(const std::array<Vec2d, 3>& corners, double b, double c) {
  return corners[0] * (1 - b - c) + corners[1] * b + corners[2] * c;
}

double triangleArea(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  return glm::length(glm::cross(b - a, c - a)) / 2;
}

double piecesFor(double length, double turn, double longestEdge) {
  return std::max({1.0, std::ceil(length / longestEdge), std::ceil(turn / MAX_TURN)});
}

/** Barycentric weights of a triangle's second and third vertex at a point near its plane. */
Vec2d barycentric(const TriangleMesh& mesh, uint32_t triangle, const Vec3f& position) {
  const glm::uvec3& index = mesh.indices()[triangle];
  const Vec3d origin = mesh.positions()[index.x], u = Vec3d(mesh.positions()[index.y]) - origin,
              v = Vec3d(mesh.positions()[index.z]) - origin, d = Vec3d(position) - origin;
  // Solved by the normal equations.
  const double uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v), du = glm::dot(d, u),
               dv = glm::dot(d, v), determinant = uu * vv - uv * uv;
  if (!(determinant > 0)) return Vec2d(0);
  const Vec2d w = glm::clamp(Vec2d(vv * du - uv * dv, uu * dv - uv * du) / determinant, 0.0, 1.0);
  return w / std::max(1.0, w.x + w.y);
}

} // namespace

// ------------------------------------------------------------------------------------------------ grids

uint32_t Patches::Face::corner(const glm::uvec2& at) const {
  const uint32_t before =
      isTriangle ? at.x * (divisions.x + 1) - at.x * (at.x - 1) / 2 : at.x * (divisions.y + 1);
  return firstCorner + before + at.y;
}

uint32_t Patches::Face::patch(const Cell& c) const {
  const uint32_t before = isTriangle ? c.i * (2 * divisions.x - c.i) : 2 * c.i * divisions.y;
  return firstPatch + before + 2 * c.j + c.upper;
}

Patches::Cell Patches::Face::cell(uint32_t patch) const {
  const uint32_t k = patch - firstPatch;
  const auto before = [this](uint32_t i) {
    return isTriangle ? i * (2 * divisions.x - i) : 2 * i * divisions.y;
  };
  uint32_t i = 0;
  while (i + 1 < divisions.x && k >= before(i + 1)) ++i;
  const uint32_t remainder = k - before(i);
  return {i, remainder / 2, remainder % 2 == 1};
}

Vec2d Patches::Face::coordinates(const Hit& hit) const {
  if (isTriangle) return barycentric(*shape->triangleMesh(), number, hit.point.position);
  return glm::clamp(shape->facePointOf(hit.primitive, hit.point).uv, 0.0, 1.0);
}

SurfacePoint Patches::Face::pointAt(const Vec2d& uv) const {
  return isTriangle ? shape->surfaceAt(number, HitParameters(Vec2f(uv))) : shape->pointOnFace({number, uv});
}

Vec2d Patches::Face::pieces(double longestEdge) const {
  if (isTriangle) {
    const Vec3d a = pointAt({0, 0}).position, b = pointAt({1, 0}).position, c = pointAt({0, 1}).position;
    return Vec2d(
        piecesFor(std::max({glm::length(b - a), glm::length(c - a), glm::length(c - b)}), 0, longestEdge));
  }
  Vec2d most(1);
  for (int axis = 0; axis < 2; ++axis) {
    for (int line = 0; line < LINES; ++line) {
      double length = 0, turn = 0;
      SurfacePoint before;
      for (int i = 0; i <= PIECES; ++i) {
        Vec2d uv(double(line) / (LINES - 1));
        uv[axis] = double(i) / PIECES;
        const SurfacePoint point = pointAt(uv);
        if (i > 0) {
          length += glm::length(Vec3d(point.position) - Vec3d(before.position));
          turn += std::acos(
              std::clamp(double(glm::dot(point.geometricNormal, before.geometricNormal)), -1.0, 1.0));
        }
        before = point;
      }
      most[axis] = std::max(most[axis], piecesFor(length, turn, longestEdge));
    }
  }
  return most;
}

// ---------------------------------------------------------------------------------------------- patches

void Patches::dice(const Scene& scene, float longestEdge) {
  const std::vector<SceneShape>& shapes = scene.shapes();
  double area = 0;
  for (const SceneShape& s : shapes) area += isCut(s) ? double(s.shape->area()) : 0;
  size = longestEdge > 0 ? longestEdge
         : area > 0      ? static_cast<float>(std::sqrt(2 * area / DEFAULT_PATCHES))
                         : scene.bounds().radius;
  const auto cutShapes = static_cast<size_t>(std::count_if(shapes.begin(), shapes.end(), isCut));
  ignored = scene.contents().shapes > cutShapes ? scene.contents().shapes - cutShapes : 0;
  faces = facesOf(scene);
  if (longestEdge > 0) {
    requireFew(double(longestEdge));
    cut(double(MAX_PATCHES));
  } else {
    size_t before = std::numeric_limits<size_t>::max();
    for (cut(MAX_DIVISIONS); count() > MAX_PATCHES && count() < before; cut(MAX_DIVISIONS)) {
      before = count();
      size *= 1.25f;
    }
  }
  areas.resize(count());
  for (uint32_t p = 0; p < count(); ++p) areas[p] = opaqueArea(p);
  shareCorners();
}

std::vector<Patches::Face> Patches::facesOf(const Scene& scene) {
  std::vector<Face> all;
  firstFace.assign(scene.shapes().size(), -1);
  for (size_t s = 0; s < scene.shapes().size(); ++s) {
    const Shape* shape = scene.shapes()[s].shape;
    if (!isCut(scene.shapes()[s])) continue;
    firstFace[s] = static_cast<int>(all.size());
    const bool isMesh = shape->triangleMesh() != nullptr;
    const uint32_t number = isMesh ? shape->primitiveCount() : shape->faceCount();
    for (uint32_t i = 0; i < number; ++i)
      all.push_back(
          Face{.shape = shape, .material = scene.shapes()[s].material, .number = i, .isTriangle = isMesh});
  }
  return all;
}

void Patches::requireFew(double longestEdge) const {
  double patches = 0;
  for (const Face& f : faces) {
    const Vec2d n = f.pieces(longestEdge);
    patches += (f.isTriangle ? 1 : 2) * n.x * n.y;
  }
  const auto most = double(std::max(MAX_PATCHES, 2 * faces.size()));
  if (patches > most)
    throw Error(formatted("radiosity: \"patchsize\" %.3g makes %.3g patches, and the limit is %.3g: remove "
                          "\"patchsize\", or set it to %.3g",
                          longestEdge, patches, most, longestEdge * std::sqrt(2 * patches / most)));
}

void Patches::cut(double maxDivisions) {
  faceOfPatch.clear();
  uint32_t corners = 0;
  for (size_t i = 0; i < faces.size(); ++i) {
    Face& f = faces[i];
    f.divisions = glm::uvec2(glm::min(f.pieces(double(size)), maxDivisions));
    f.firstPatch = static_cast<uint32_t>(faceOfPatch.size());
    f.firstCorner = corners;
    corners += f.cornerCount();
    faceOfPatch.insert(faceOfPatch.end(), f.patchCount(), static_cast<uint32_t>(i));
  }
}

std::array<uint32_t, 3> Patches::corners(uint32_t patch) const {
  const Face& face = faces[faceOfPatch[patch]];
  std::array<uint32_t, 3> out{};
  const std::array<glm::uvec2, 3> grid = face.cell(patch).corners();
  for (size_t k = 0; k < 3; ++k) out[k] = sharedCorner[face.corner(grid[k])];
  return out;
}

std::array<Vec2d, 3> Patches::cornerCoordinates(uint32_t patch) const {
  const Face& face = faces[faceOfPatch[patch]];
  const std::array<glm::uvec2, 3> grid = face.cell(patch).corners();
  return {face.atGrid(grid[0]), face.atGrid(grid[1]), face.atGrid(grid[2])};
}

RadiosityPatch Patches::describe(uint32_t patch) const {
  const Face& face = faces[faceOfPatch[patch]];
  const std::array<Vec2d, 3> corners = cornerCoordinates(patch);
  RadiosityPatch out;
  for (size_t k = 0; k < 3; ++k) out.corners[k] = face.pointAt(corners[k]).position;
  SurfacePoint centroid = face.pointAt(within(corners, 1.0 / 3, 1.0 / 3));
  out.normal = centroid.geometricNormal;
  out.area = areas[patch];
  if (face.material->detail) face.material->detail->apply(centroid);
  BsdfArena arena;
  const Bsdf* bsdf = face.material->bsdfAt(centroid, arena);
  for (size_t side = 0; side < 2; ++side)
    out.albedo[side] = bsdf ? bsdf->albedo(Vec3f(0, 0, side == 0 ? 1 : -1)) : BLACK;
  return out;
}

float Patches::opaqueArea(uint32_t patch) const {
  const Face& face = faces[faceOfPatch[patch]];
  const std::array<Vec2d, 3> corners = cornerCoordinates(patch);
  const auto at = [&](double i, double j) {
    return face.pointAt(within(corners, i / AREA_PIECES, j / AREA_PIECES));
  };
  if (face.isTriangle && !face.shape->alpha)
    return static_cast<float>(triangleArea(face.pointAt(corners[0]).position,
                                           face.pointAt(corners[1]).position,
                                           face.pointAt(corners[2]).position));
  double sum = 0, whole = 0;
  const auto add = [&](int i, int j, int side) {
    const double third = side / 3.0;
    const double area = triangleArea(at(i, j).position, at(i + side, j).position, at(i, j + side).position);
    whole += area;
    sum += area * double(opacity(*face.shape, at(i + third, j + third)));
  };
  for (int i = 0; i < AREA_PIECES; ++i)
    for (int j = 0; i + j < AREA_PIECES; ++j) {
      add(i, j, 1);
      if (i + j + 2 <= AREA_PIECES) add(i + 1, j + 1, -1);
    }
  // Minimum for patches whose opaque parts are between the tested points.
  return static_cast<float>(std::max(sum, whole / (2 * AREA_PIECES * AREA_PIECES)));
}

void Patches::shareCorners() {
  constexpr float COPLANAR = 0.9f; // cosine between the normals of shared corners
  struct Shared {
    Vec3f normal;
    uint32_t index;
  };
  const double grain = double(size) * 1e-3;
  using Key = std::array<int64_t, 3>;
  std::map<Key, std::vector<Shared>> found;
  const auto keyOf = [&](const Vec3d& p) {
    return Key{std::llround(p.x), std::llround(p.y), std::llround(p.z)};
  };
  /** Corner found before at this position on a surface with a similar normal. Rounding may have put it in a
   * neighbouring cell, up to a quarter of a grain away. */
  const auto sameCorner = [&](const Vec3d& p, const Vec3f& normal) -> std::optional<uint32_t> {
    for (int k = 0; k < 8; ++k) {
      const auto there =
          found.find(keyOf(p + Vec3d(k & 1 ? .25 : -.25, k & 2 ? .25 : -.25, k & 4 ? .25 : -.25)));
      if (there == found.end()) continue;
      for (const Shared& s : there->second)
        if (glm::dot(s.normal, normal) > COPLANAR) return s.index;
    }
    return {};
  };
  sharedCorner.clear();
  sharedCornerCount = 0;
  for (const Face& f : faces)
    for (uint32_t i = 0; i <= f.divisions.x; ++i)
      for (uint32_t j = 0; f.isTriangle ? i + j <= f.divisions.x : j <= f.divisions.y; ++j) {
        const SurfacePoint point = f.pointAt(f.atGrid({i, j}));
        const Vec3d p = Vec3d(point.position) / grain;
        const auto known = sameCorner(p, point.geometricNormal);
        sharedCorner.push_back(known ? *known : sharedCornerCount);
        if (!known) found[keyOf(p)].push_back({point.geometricNormal, sharedCornerCount++});
      }
}

std::optional<PatchPoint> Patches::find(const Hit& hit) const {
  if (hit.shape < 0 || firstFace[static_cast<size_t>(hit.shape)] < 0) return {};
  const auto first = static_cast<uint32_t>(firstFace[static_cast<size_t>(hit.shape)]);
  const bool isTriangle = faces[first].isTriangle;
  const uint32_t number =
      isTriangle ? hit.primitive : faces[first].shape->facePointOf(hit.primitive, hit.point).face;
  const Face& face = faces[first + number];
  const Vec2d at = face.coordinates(hit) * Vec2d(face.divisions);
  Cell cell;
  cell.i = std::min(static_cast<uint32_t>(at.x), face.divisions.x - 1);
  cell.j = std::min(static_cast<uint32_t>(at.y), face.divisions.y - 1 - (isTriangle ? cell.i : 0));
  const float f = std::clamp(static_cast<float>(at.x - cell.i), 0.0f, 1.0f),
              g = std::clamp(static_cast<float>(at.y - cell.j), 0.0f, 1.0f);
  cell.upper = f + g > 1 && (!isTriangle || cell.i + cell.j + 2 <= face.divisions.x);
  PatchPoint out;
  out.patch = face.patch(cell);
  out.corners = corners(out.patch);
  if (cell.upper)
    out.weights = {1 - g, 1 - f, f + g - 1};
  else
    out.weights = {std::max(0.0f, 1 - f - g), f, g};
  return out;
}

SurfacePoint Patches::sample(uint32_t patch, Sampler& sampler) const {
  const Face& face = faces[faceOfPatch[patch]];
  const std::array<Vec2d, 3> corners = cornerCoordinates(patch);
  SurfacePoint point;
  for (int i = 0; i < MAX_TRIES; ++i) {
    const Vec2f a = sampler.next2D();
    const double root = std::sqrt(double(a.x));
    point = face.pointAt(within(corners, root * (1 - double(a.y)), root * double(a.y)));
    if (!face.shape->alpha || sampler.next1D() < opacity(*face.shape, point)) break;
  }
  return point;
}

} // namespace recurse
