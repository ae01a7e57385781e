/** @file
 * Triangle meshes: baking, shading data, error bounds that fit Embree's arithmetic, sampling by area.
 */
#include "recurse/model/mesh/triangleMesh.h"

#include <string>

namespace recurse {

namespace {

template <class From> bool finite(const From& v) {
  for (int i = 0; i < From::length(); ++i)
    if (!std::isfinite(v[i])) return false;
  return true;
}

std::string numbered(const char* what, size_t i) { return std::string(what) + " " + std::to_string(i); }

/** Checks a per-vertex array, and converts each element. */
template <class To, class From, class Convert>
std::vector<To> perVertex(const std::vector<From>& from, size_t vertexCount, const char* what,
                          const Convert& convert) {
  if (!from.empty() && from.size() != vertexCount)
    throw Error("there are " + std::to_string(from.size()) + " " + what + "s for " +
                std::to_string(vertexCount) + " positions");
  std::vector<To> to;
  to.reserve(from.size());
  for (size_t i = 0; i < from.size(); ++i) {
    if (!finite(from[i])) throw Error(numbered(what, i) + " is not finite");
    to.push_back(convert(from[i]));
    if (!finite(to.back())) throw Error(numbered(what, i) + " is too large for single precision");
  }
  return to;
}

template <class T> void discard(std::vector<T>& v) { std::vector<T>().swap(v); }

/** Normalises a vector; zero stays zero, and means that there is none. */
Vec3f unitOrZero(const Vec3d& v) {
  const double largest = std::max(std::abs(v.x), std::max(std::abs(v.y), std::abs(v.z)));
  if (!(largest > 0)) return Vec3f(0);
  return Vec3f(glm::normalize(v / largest));
}

/** Some unit vector perpendicular to v, for triangles that have no area; v may be zero. */
Vec3d anyPerpendicular(const Vec3d& v) {
  if (glm::dot(v, v) == 0) return {0, 0, 1};
  const Vec3d a = glm::abs(v);
  const Vec3d axis = a.x <= a.y && a.x <= a.z ? Vec3d(1, 0, 0) : a.y <= a.z ? Vec3d(0, 1, 0) : Vec3d(0, 0, 1);
  return glm::normalize(glm::cross(v, axis));
}

/** The distance from a triangle's plane, in exact arithmetic, within which Embree's robust intersector may
 * find a point on the wrong side: doc-files/notes/embree-error.md. */
double embreePlaneError(const Vec3d& extent, const Vec3d& unitNormal, double normalLength) {
  constexpr double UNIT = 0x1p-24;
  const double largest = std::max(extent.x, std::max(extent.y, extent.z));
  if (!(normalLength > 0)) return largest;
  const double dotError = 4 * glm::dot(extent, glm::abs(unitNormal));
  const double normalError = 16 * extent.x * extent.y * extent.z / normalLength;
  // Upper bound: the plane of a sliver may be undefined, but its error is no larger than its size. Lower
  // bound: rays have to start off the plane even where the error is zero, by more than a denormal number.
  return std::clamp(UNIT * (dotError + normalError), UNIT / 16 * largest, largest);
}

} // namespace

TriangleMesh::TriangleMesh(const MeshData& data, const ShapeContext& context)
    : TriangleMesh(MeshData(data), context) {}

TriangleMesh::TriangleMesh(MeshData&& data, const ShapeContext& context)
    : triangles(std::move(data.triangles)) {
  const Mat4d& m = context.sceneFromObject;
  const Mat3d normalFromObject = glm::transpose(glm::inverse(Mat3d(m)));
  const double side = context.reverseOrientation ? -1 : 1;
  flipped = context.reverseOrientation != swapsHandedness(m);

  const size_t count = data.positions.size();
  vertices = perVertex<Vec3f>(data.positions, count, "position",
                              [&](const Vec3d& p) { return Vec3f(transformPoint(m, p)); });
  discard(data.positions);
  normals = perVertex<Vec3f>(data.normals, count, "normal",
                             [&](const Vec3d& n) { return unitOrZero(normalFromObject * n * side); });
  discard(data.normals);
  tangents = perVertex<Vec3f>(data.tangents, count, "tangent",
                              [&](const Vec3d& t) { return Vec3f(transformVector(m, t)); });
  discard(data.tangents);
  uvs = perVertex<Vec2f>(data.uvs, count, "texture coordinate", [](const Vec2d& t) { return Vec2f(t); });
  discard(data.uvs);

  double sum = 0;
  for (size_t i = 0; i < triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k)
      if (triangles[i][k] >= count)
        throw Error(numbered("triangle", i) + " names vertex " + std::to_string(triangles[i][k]) +
                    ", but there are " + std::to_string(count));
    sum += 0.5 * glm::length(windingNormal(triangles[i]));
  }
  totalArea = static_cast<float>(sum);
  planes.reserve(triangles.size());
  for (const glm::uvec3& t : triangles) planes.push_back(planeOf(t));
}

Vec3d TriangleMesh::windingNormal(const glm::uvec3& t) const {
  const Vec3d a = vertices[t.x];
  return glm::cross(Vec3d(vertices[t.y]) - a, Vec3d(vertices[t.z]) - a);
}

Bounds3f TriangleMesh::bounds(uint32_t primitive) const {
  Bounds3f b;
  for (int k = 0; k < 3; ++k) b.add(vertices[triangles[primitive][k]]);
  return b;
}

std::optional<PrimitiveHit> TriangleMesh::intersect(uint32_t, const Vec3f&, const Vec3f&, float,
                                                    float) const {
  throw std::logic_error("triangles are intersected by Embree");
}

TriangleMesh::Plane TriangleMesh::planeOf(const glm::uvec3& t) const {
  const Vec3d p0 = vertices[t.x], e1 = Vec3d(vertices[t.y]) - p0, e2 = Vec3d(vertices[t.z]) - p0;
  Vec3d normal = glm::cross(e1, e2);
  const double normalLength = glm::length(normal);
  if (normalLength > 0)
    normal /= normalLength;
  else
    normal = anyPerpendicular(glm::dot(e1, e1) > glm::dot(e2, e2) ? e1 : e2);
  const Vec3d extent = glm::max(Vec3d(0), glm::max(e1, e2)) - glm::min(Vec3d(0), glm::min(e1, e2));
  return {Vec3f(flipped ? -normal : normal),
          static_cast<float>(embreePlaneError(extent, normal, normalLength))};
}

template <bool ALL> SurfacePoint TriangleMesh::pointAt(uint32_t primitive, const Vec2f& parameters) const {
  const glm::uvec3& triangle = triangles[primitive];
  const Plane& plane = planes[primitive];
  // Rounding may put Embree's barycentric coordinates just outside of the triangle.
  double b1 = std::clamp(double(parameters.x), 0.0, 1.0), b2 = std::clamp(double(parameters.y), 0.0, 1.0);
  if (b1 + b2 > 1) {
    const double sum = b1 + b2;
    b1 /= sum;
    b2 /= sum;
  }
  const auto interpolated = [&](const auto& values) {
    using V = glm::vec<std::decay_t<decltype(values[0])>::length(), double>;
    return V(values[triangle.x]) * (1 - b1 - b2) + V(values[triangle.y]) * b1 + V(values[triangle.z]) * b2;
  };
  const Vec3d p0 = vertices[triangle.x], e1 = Vec3d(vertices[triangle.y]) - p0,
              e2 = Vec3d(vertices[triangle.z]) - p0;

  SurfacePoint s;
  // Interpolation along edges keeps a coordinate that all vertices share exact.
  s.position = Vec3f(p0 + e1 * b1 + e2 * b2);
  Vec3f rounding = magnitude(s.position);
  for (int i = 0; i < 3; ++i)
    rounding[i] *=
        float(int(e1[i] != 0) | int(e2[i] != 0)); // a coordinate that all vertices share has no error
  s.error = positionError(rounding, plane.normal, plane.error);

  s.geometricNormal = plane.normal;
  s.shadingNormal = plane.normal;
  float normalLength = 0; // before normalisation; 0: the plane's normal is used
  if (!normals.empty()) {
    const Vec3d shading = interpolated(normals);
    const double length = glm::length(shading);
    if (length > 1e-6) { // unit normals that nearly cancel leave rounding errors only
      s.shadingNormal = Vec3f(shading / length);
      normalLength = static_cast<float>(length);
      if (glm::dot(s.shadingNormal, s.geometricNormal) < 0) s.geometricNormal = -s.geometricNormal;
    }
  }

  if constexpr (!ALL) return s;
  // Shading directions are computed in single precision, which suffices and costs less at each hit.
  const Vec3f& v0 = vertices[triangle.x];
  const Vec3f along1 = vertices[triangle.y] - v0, along2 = vertices[triangle.z] - v0;
  Vec2f d1(1, 0), d2(1, 1); // pbrt's defaults: (0,0), (1,0), (1,1)
  if (uvs.empty()) {
    s.uv = Vec2f(static_cast<float>(b1 + b2), static_cast<float>(b2));
  } else {
    s.uv = Vec2f(interpolated(uvs));
    d1 = uvs[triangle.y] - uvs[triangle.x];
    d2 = uvs[triangle.z] - uvs[triangle.x];
  }
  const float a = d1.x * d2.y, b = d1.y * d2.x, determinant = a - b;
  // A determinant of mere rounding errors defines no direction.
  const float scale = std::abs(determinant) > 1e-6f * (std::abs(a) + std::abs(b)) ? 1 / determinant : 0.0f;
  s.dpdu = (along1 * d2.y - along2 * d1.y) * scale;
  s.dpdv = (along2 * d1.x - along1 * d2.x) * scale;
  if (!normals.empty() && normalLength > 0) {
    const float turnScale = scale / normalLength;
    const Vec3f& n0 = normals[triangle.x];
    const Vec3f &n = s.shadingNormal, turn1 = normals[triangle.y] - n0, turn2 = normals[triangle.z] - n0;
    const auto alongSurface = [&](const Vec3f& turn) { return (turn - n * glm::dot(n, turn)) * turnScale; };
    s.dndu = alongSurface(turn1 * d2.y - turn2 * d1.y);
    s.dndv = alongSurface(turn2 * d1.x - turn1 * d2.x);
    s.crossTangent = 1;
  }
  if (!tangents.empty())
    if (const Vec3d along = interpolated(tangents); along != Vec3d(0)) s.dpdu = Vec3f(along);
  return s;
}

SurfacePoint TriangleMesh::surfaceAt(uint32_t primitive, const HitParameters& parameters) const {
  return pointAt<true>(primitive, parameters.uv);
}
SurfacePoint TriangleMesh::placeAt(uint32_t primitive, const HitParameters& parameters) const {
  return pointAt<false>(primitive, parameters.uv);
}

void TriangleMesh::tabulateAreas() const {
  cumulativeArea.reserve(triangles.size());
  double sum = 0;
  for (const glm::uvec3& t : triangles) cumulativeArea.push_back(sum += 0.5 * glm::length(windingNormal(t)));
  tabulated.store(true, std::memory_order_release);
}

ShapeSample TriangleMesh::sampleArea(float pick, const Vec2f& u) const {
  if (!tabulated.load(std::memory_order_acquire)) std::call_once(once, [this] { tabulateAreas(); });
  if (!(totalArea > 0)) return {};
  // A float has too few digits to select among millions of triangles: u.x adds the lower ones. In large
  // meshes the point within the triangle therefore uses the remainder of the selection instead of u.x.
  const double chosen = double(pick) + double(u.x) * 0x1p-24;
  const double wanted = chosen * cumulativeArea.back();
  // First sum above `wanted`: a triangle without area adds nothing and is never the first.
  auto found = std::upper_bound(cumulativeArea.begin(), cumulativeArea.end(), wanted);
  if (found == cumulativeArea.end())
    found = std::lower_bound(cumulativeArea.begin(), cumulativeArea.end(), cumulativeArea.back());
  const auto i = static_cast<size_t>(found - cumulativeArea.begin());
  Vec2f within = u;
  constexpr size_t MAX_WHOLE_SAMPLES = 4096;
  if (triangles.size() > MAX_WHOLE_SAMPLES) {
    const double below = i > 0 ? cumulativeArea[i - 1] : 0;
    within.x = std::clamp(static_cast<float>((wanted - below) / (*found - below)), 0.0f, ONE_MINUS_EPSILON);
  }
  // Heitz, "A Low-Distortion Map Between Triangle and Square" (2019).
  const float half = std::min(within.x, within.y) * 0.5f;
  const bool above = within.y > within.x;
  return {surfaceAt(static_cast<uint32_t>(i),
                    HitParameters(Vec2f(above ? half : within.x - half, above ? within.y - half : half))),
          1 / totalArea, static_cast<uint32_t>(i)};
}

} // namespace recurse
