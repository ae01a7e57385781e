/** @file
 * Meshes of bilinear patches: surfaces through four corners, straight along both coordinates. Ray
 * intersection follows Reshetov, "Cool Patches: A Geometric Approach to Ray/Bilinear Patch Intersections"
 * (Ray Tracing Gems, chapter 8, 2019), here in double precision. Corners are rounded to float like the
 * corners of triangles, so that meshes of both kinds fit together.
 */
#include <array>

#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** p(u, v) = corner + u·alongU + v·alongV + uv·twist */
struct Patch {
  Vec3d corner, alongU, alongV, twist;

  Vec3d offset(double u, double v) const { return alongU * u + alongV * v + twist * (u * v); }
  Vec3d dpdu(double v) const { return alongU + twist * v; }
  Vec3d dpdv(double u) const { return alongV + twist * u; }
  Vec3d across(double u, double v) const { return glm::cross(dpdu(v), dpdv(u)); }
  bool isParallelogram() const { return twist == Vec3d(0); }

  Vec2d coordinatesOf(const SurfacePoint& point) const {
    // Intersection along the normal, close to the point, and slightly beyond the edges by rounding.
    double nearest = std::numeric_limits<double>::infinity();
    Vec2d uv(0.5);
    intersectPosition(point.position, point.geometricNormal, 0.01, [&](double t, double u, double v) {
      if (std::abs(t) >= nearest) return;
      nearest = std::abs(t);
      uv = {u, v};
    });
    return uv;
  }

  /**
   * Calls visit(t, u, v) for each intersection with the line origin + t·direction where u and v are in [0,
   * 1], or outside by at most `beyond`.
   */
  template <class Visit>
  void intersectPosition(const Vec3d& origin, const Vec3d& direction, double beyond,
                         const Visit& visit) const {
    // The origin is moved near the patch, so that distance costs no precision.
    const Vec3d middle = corner + offset(0.5, 0.5);
    const double tNear = glm::dot(middle - origin, direction) / glm::dot(direction, direction);
    const Vec3d q00 = corner - (origin + direction * tNear), across00 = glm::cross(q00, direction);
    if (isParallelogram()) { // u and v are linear
      const Vec3d normal = across(0, 0);
      const double slope = glm::dot(normal, direction);
      const double u = glm::dot(across00, alongV) / slope, v = -glm::dot(across00, alongU) / slope;
      if (u >= -beyond && u <= 1 + beyond && v >= -beyond && v <= 1 + beyond)
        visit(glm::dot(normal, corner - origin) / slope, std::clamp(u, 0.0, 1.0), std::clamp(v, 0.0, 1.0));
      return;
    }
    const Vec3d q10 = q00 + alongU, edge1 = alongV + twist;
    // The line crosses the patch's line of constant u where this is zero: a + b u + c u²
    const double a = glm::dot(across00, alongV);
    const double c = glm::dot(glm::cross(twist, alongU), direction);
    const double b = glm::dot(glm::cross(q10, direction), edge1) - a - c;
    const double discriminant = b * b - 4 * a * c;
    if (!(discriminant >= 0)) return;
    const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
    if (c != 0) intersectAt(q / c, origin, direction, beyond, visit);
    if (q != 0) intersectAt(a / q, origin, direction, beyond, visit);
  }

 private:
  template <class Visit>
  void intersectAt(double u, const Vec3d& origin, const Vec3d& direction, double beyond,
                   const Visit& visit) const {
    if (!(u >= -beyond && u <= 1 + beyond)) return;
    u = std::clamp(u, 0.0, 1.0);
    const Vec3d start = corner - origin + alongU * u, along = dpdv(u);
    const Vec3d n = glm::cross(direction, along);
    const double n2 = glm::dot(n, n);
    if (!(n2 > 0)) return;
    double v = glm::dot(glm::cross(start, direction), n) / n2;
    if (!(v >= -beyond && v <= 1 + beyond)) return;
    v = std::clamp(v, 0.0, 1.0);
    // t is computed from the tangent plane, which errors of u and v along the surface do not change. An
    // axis-aligned patch is intersected exactly.
    const Vec3d normal = across(u, v);
    const double slope = glm::dot(normal, direction);
    if (slope == 0) return;
    visit(glm::dot(normal, corner - origin + offset(u, v)) / slope, u, v);
  }
};

/** Area of p([u0, u0+size], [v0, v0+size]) by five-point Gauss quadrature. */
double gaussArea(const Patch& p, double u0, double v0, double size) {
  constexpr double NODE[] = {-0.9061798459386640, -0.5384693101056831, 0, 0.5384693101056831,
                             0.9061798459386640},
                   WEIGHT[] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
                               0.2369268850561891};
  double sum = 0;
  for (int i = 0; i < 5; ++i)
    for (int k = 0; k < 5; ++k)
      sum += WEIGHT[i] * WEIGHT[k] *
             glm::length(p.across(u0 + size * 0.5 * (1 + NODE[i]), v0 + size * 0.5 * (1 + NODE[k])));
  return 0.25 * size * size * sum;
}

/** Adaptive quadrature: splits in four until the parts agree with the whole. */
double patchArea(const Patch& p, double u0, double v0, double size, double whole, double tolerance,
                 int depth) {
  const double half = 0.5 * size;
  std::array<double, 4> parts;
  for (int i = 0; i < 4; ++i) parts[i] = gaussArea(p, u0 + half * (i & 1), v0 + half * (i >> 1), half);
  const double sum = parts[0] + parts[1] + parts[2] + parts[3];
  if (depth == 0 || std::abs(sum - whole) <= tolerance) return sum;
  double area = 0;
  for (int i = 0; i < 4; ++i)
    area +=
        patchArea(p, u0 + half * (i & 1), v0 + half * (i >> 1), half, parts[i], 0.25 * tolerance, depth - 1);
  return area;
}

double patchArea(const Patch& p) {
  if (p.isParallelogram()) return glm::length(p.across(0, 0));
  const double whole = gaussArea(p, 0, 0, 1);
  return patchArea(p, 0, 0, 1, whole, 1e-7 * whole, 8);
}

/** Maps uniform u to x in [0, 1] with a linear density, a at 0 and b at 1. */
double sampleLinear(double u, double a, double b) {
  if (!(a + b > 0)) return u;
  return std::min(u * (a + b) / (a + std::sqrt((1 - u) * a * a + u * b * b)), 1.0);
}

/** Density on the unit square, proportional to the area stretch at the corners and bilinear between. It is
 * nowhere less than the stretch itself, which is convex along u and along v. */
struct CornerDensity {
  double w00, w10, w01, w11;

  explicit CornerDensity(const Patch& p)
      : w00(glm::length(p.across(0, 0))), w10(glm::length(p.across(1, 0))), w01(glm::length(p.across(0, 1))),
        w11(glm::length(p.across(1, 1))) {}
  double at(double u, double v) const {
    return 4 * ((w00 * (1 - u) + w10 * u) * (1 - v) + (w01 * (1 - u) + w11 * u) * v) /
           (w00 + w10 + w01 + w11);
  }
  Vec2d sample(const Vec2f& x) const {
    const double v = sampleLinear(double(x.y), w00 + w10, w01 + w11);
    return {sampleLinear(double(x.x), w00 * (1 - v) + w01 * v, w10 * (1 - v) + w11 * v), v};
  }
};

class BilinearMesh final : public Shape {
 public:
  BilinearMesh(const std::vector<Vec3d>& positions, const std::vector<Vec3d>& objectNormals,
               const std::vector<Vec2d>& coordinates, std::vector<glm::uvec4> corners,
               const ShapeContext& context)
      : corners(std::move(corners)) {
    const Mat4d& m = context.sceneFromObject;
    const Mat3d normalFromObject = glm::transpose(glm::inverse(Mat3d(m)));
    const double side = context.reverseOrientation ? -1 : 1;
    flipped = context.reverseOrientation != swapsHandedness(m);
    for (const Vec3d& p : positions) {
      vertices.emplace_back(transformPoint(m, p));
      if (!isFinite(vertices.back())) throw Error("a position is too large for single precision");
    }
    for (const Vec3d& n : objectNormals) {
      const Vec3d transformed = normalFromObject * n * side;
      const double length = glm::length(transformed);
      normals.push_back(length > 0 ? Vec3f(transformed / length) : Vec3f(0));
    }
    for (const Vec2d& t : coordinates) uvs.emplace_back(t);
    double sum = 0;
    for (uint32_t i = 0; i < primitiveCount(); ++i) {
      areas.push_back(patchArea(patch(i)));
      cumulativeArea.push_back(sum += areas.back());
    }
  }

  uint32_t primitiveCount() const override { return static_cast<uint32_t>(corners.size()); }

  /** A patch is inside the convex hull of its corners. */
  Bounds3f bounds(uint32_t primitive) const override {
    Bounds3f b;
    for (int k = 0; k < 4; ++k) b.add(vertices[corners[primitive][k]]);
    return b;
  }

  std::optional<PrimitiveHit> intersect(uint32_t primitive, const Vec3f& origin, const Vec3f& direction,
                                        float tMin, float tMax) const override {
    PrimitiveHit nearest;
    nearest.t = tMax;
    // Slack at the edges, which neighbours share: rounding must not open them.
    constexpr double EDGE_ROUNDING = 1e-13;
    patch(primitive).intersectPosition(origin, direction, EDGE_ROUNDING, [&](double t, double u, double v) {
      const auto rounded = static_cast<float>(t);
      if (rounded > tMin && rounded < nearest.t) nearest = {rounded, HitParameters(Vec2f(u - 0.5, v - 0.5))};
    });
    if (!(nearest.t < tMax)) return {};
    return nearest;
  }

  /** Hit parameters are u and v from the middle, where large patches then have the highest precision. */
  SurfacePoint surfaceAt(uint32_t primitive, const HitParameters& parameters) const override {
    return pointAt(primitive, patch(primitive), std::clamp(double(parameters.uv.x) + 0.5, 0.0, 1.0),
                   std::clamp(double(parameters.uv.y) + 0.5, 0.0, 1.0));
  }

  std::vector<RimPiece> rim() const override {
    std::vector<RimPiece> pieces;
    for (const glm::uvec4& c : corners) {
      const uint32_t around[] = {c.x, c.y, c.w, c.z};
      for (size_t k = 0; k < 4; ++k) {
        const Vec3f &from = vertices[around[k]], &to = vertices[around[(k + 1) % 4]];
        const Vec3f opposite = 0.5f * (vertices[around[(k + 2) % 4]] + vertices[around[(k + 3) % 4]]);
        if (from != to) pieces.push_back({from, to, opposite});
      }
    }
    return pieces;
  }

  float area() const override {
    return cumulativeArea.empty() ? 0 : static_cast<float>(cumulativeArea.back());
  }

  ShapeSample sampleArea(float pick, const Vec2f& u) const override {
    ShapeSample s;
    if (!(area() > 0)) return s;
    const double wanted = (double(pick) + double(u.x) * 0x1p-24) * cumulativeArea.back();
    auto found = std::upper_bound(cumulativeArea.begin(), cumulativeArea.end(), wanted);
    if (found == cumulativeArea.end())
      found = std::lower_bound(cumulativeArea.begin(), cumulativeArea.end(), cumulativeArea.back());
    const auto primitive = static_cast<uint32_t>(found - cumulativeArea.begin());
    s.primitive = primitive;
    const Patch p = patch(primitive);
    if (p.isParallelogram()) {
      s.point = pointAt(primitive, p, double(u.x), double(u.y));
      s.pdf = 1 / area();
      return s;
    }
    const Vec2d place = CornerDensity(p).sample(u);
    s.point = pointAt(primitive, p, place.x, place.y);
    s.pdf = pdfAt(primitive, p, place.x, place.y);
    return s;
  }

  float pdfArea(uint32_t primitive, const SurfacePoint& point) const override {
    const Patch p = patch(primitive);
    if (p.isParallelogram()) return 1 / area();
    const Vec2d uv = p.coordinatesOf(point);
    return pdfAt(primitive, p, uv.x, uv.y);
  }

  uint32_t faceCount() const override { return primitiveCount(); }
  SurfacePoint pointOnFace(const FacePoint& p) const override {
    return pointAt(p.face, patch(p.face), p.uv.x, p.uv.y);
  }
  FacePoint facePointOf(uint32_t primitive, const SurfacePoint& point) const override {
    return {primitive, patch(primitive).coordinatesOf(point)};
  }

 private:
  Patch patch(uint32_t primitive) const {
    const glm::uvec4& c = corners[primitive];
    const Vec3d p00 = vertices[c.x], p10 = vertices[c.y], p01 = vertices[c.z], p11 = vertices[c.w];
    return {p00, p10 - p00, p01 - p00, (p11 - p10) - (p01 - p00)};
  }

  float pdfAt(uint32_t primitive, const Patch& p, double u, double v) const {
    const double stretch = glm::length(p.across(u, v));
    if (!(stretch > 0)) return 0;
    return static_cast<float>(areas[primitive] / cumulativeArea.back() * CornerDensity(p).at(u, v) / stretch);
  }

  template <class V>
  auto bilinear(const std::vector<V>& values, const glm::uvec4& c, double u, double v) const {
    using D = glm::vec<V::length(), double>;
    return (D(values[c.x]) * (1 - u) + D(values[c.y]) * u) * (1 - v) +
           (D(values[c.z]) * (1 - u) + D(values[c.w]) * u) * v;
  }

  /** Unit normal of a patch where it is well defined; otherwise the normal of the middle, or any. */
  static Vec3d unitNormal(const Patch& p, double u, double v) {
    for (const Vec3d& n : {p.across(u, v), p.across(0.5, 0.5), p.across(0.25, 0.25)}) {
      const double length = glm::length(n);
      if (length > 0) return n / length;
    }
    return {0, 0, 1};
  }

  SurfacePoint pointAt(uint32_t primitive, const Patch& p, double u, double v) const {
    const glm::uvec4& c = corners[primitive];
    SurfacePoint s;
    const Vec3d position = p.corner + p.offset(u, v);
    s.position = Vec3f(position);

    Vec3d normal = unitNormal(p, u, v), shading{0};
    if (!normals.empty()) shading = bilinear(normals, c, u, v);
    const double shadingLength = glm::length(shading);
    const bool smooth = shadingLength > 1e-6; // unit normals that cancel leave only rounding behind
    if (smooth ? glm::dot(normal, shading) < 0 : flipped) normal = -normal;
    s.geometricNormal = Vec3f(normal);
    s.shadingNormal = smooth ? Vec3f(shading / shadingLength) : s.geometricNormal;
    if (glm::dot(s.shadingNormal, s.geometricNormal) < 0) s.shadingNormal = s.geometricNormal;

    // Extent of the corners along each axis; a coordinate that they share is exact.
    const Vec3d extent = glm::abs(p.alongU) + glm::abs(p.alongV) + glm::abs(p.twist);
    Vec3d rounding = position;
    for (int i = 0; i < 3; ++i)
      if (extent[i] == 0) rounding[i] = 0;
    s.error = positionError(rounding, 0x1p-50 * extent, normal, flatOffset(extent, position, normal));
    Vec3d dpdu = p.dpdu(v), dpdv = p.dpdv(u), dndu, dndv;
    if (smooth) {
      const Vec3d n00 = normals[c.x], n10 = normals[c.y], n01 = normals[c.z], n11 = normals[c.w];
      dndu = derivativeOfUnit(shading, (n10 - n00) * (1 - v) + (n11 - n01) * v, 1);
      dndv = derivativeOfUnit(shading, (n01 - n00) * (1 - u) + (n11 - n10) * u, 1);
    } else {
      const Vec3d across = glm::cross(dpdu, dpdv);
      const double side = glm::dot(across, normal) < 0 ? -1 : 1;
      dndu = derivativeOfUnit(across, glm::cross(dpdu, p.twist), side);
      dndv = derivativeOfUnit(across, glm::cross(p.twist, dpdv), side);
    }
    s.uv = {static_cast<float>(u), static_cast<float>(v)};
    if (!uvs.empty()) {
      s.uv = Vec2f(bilinear(uvs, c, u, v));
      // Chain rule, from derivatives along the patch coordinates to derivatives along (u, v) of the texture.
      const Vec2d t00 = uvs[c.x], t10 = uvs[c.y], t01 = uvs[c.z], t11 = uvs[c.w];
      const Vec2d du = (t10 - t00) * (1 - v) + (t11 - t01) * v, dv = (t01 - t00) * (1 - u) + (t11 - t10) * u;
      const double determinant = du.x * dv.y - du.y * dv.x;
      const auto byCoordinates = [&](Vec3d& byU, Vec3d& byV) {
        const Vec3d alongU = byU, alongV = byV;
        byU = (alongU * dv.y - alongV * du.y) / determinant;
        byV = (alongV * du.x - alongU * dv.x) / determinant;
      };
      if (std::abs(determinant) > 1e-9 * (std::abs(du.x * dv.y) + std::abs(du.y * dv.x))) {
        byCoordinates(dpdu, dpdv);
        byCoordinates(dndu, dndv);
      }
    }
    s.dpdu = Vec3f(dpdu);
    s.dpdv = Vec3f(dpdv);
    s.dndu = Vec3f(dndu);
    s.dndv = Vec3f(dndv);
    return s;
  }

  std::vector<Vec3f> vertices, normals;
  std::vector<Vec2f> uvs;
  std::vector<glm::uvec4> corners; ///< vertices at (u, v) = (0,0), (1,0), (0,1), (1,1)
  std::vector<double> areas, cumulativeArea;
  bool flipped = false;
};

std::unique_ptr<Shape> makeBilinearMesh(const Parameters& p, const ShapeContext& context) {
  const std::vector<Vec3d> positions = p.vector3s("P");
  const size_t count = positions.size();
  std::vector<glm::uvec4> patches;
  if (!p.has("indices")) {
    if (count != 4)
      p.fail("P", "there are " + std::to_string(count) + " positions and no \"indices\"",
             "\"indices\" with four numbers for each patch, or exactly four positions");
    patches = {{0, 1, 2, 3}};
  } else {
    const std::vector<int> indices = p.integers("indices");
    if (indices.size() % 4 != 0)
      p.fail("indices", std::to_string(indices.size()) + " indices do not form patches",
             "four for each patch");
    for (size_t i = 0; i < indices.size(); ++i)
      if (indices[i] < 0 || size_t(indices[i]) >= count)
        p.fail("indices",
               "index " + std::to_string(indices[i]) + " (number " + std::to_string(i + 1) +
                   " of the list) is not the index of a position",
               "0 to " + std::to_string(int64_t(count) - 1));
    for (size_t i = 0; i < indices.size(); i += 4)
      patches.emplace_back(indices[i], indices[i + 1], indices[i + 2], indices[i + 3]);
  }
  const auto checkCount = [&](const char* name, size_t given) {
    if (given != count)
      p.fail(name, std::to_string(given) + " given for " + std::to_string(count) + " positions",
             "one for each element of \"P\"");
  };
  std::vector<Vec3d> normals;
  if (p.has("N")) checkCount("N", (normals = p.vector3s("N")).size());
  std::vector<Vec2d> uvs;
  if (p.has("uv")) checkCount("uv", (uvs = p.vector2s("uv")).size());
  try {
    return std::make_unique<BilinearMesh>(positions, normals, uvs, std::move(patches), context);
  } catch (const Error& e) {
    p.fail("P", e.what());
  }
}

} // namespace

void registerBilinearMesh(PlugIns& plugIns) {
  plugIns.shapes.add(
      {{.name = "bilinearmesh",
        .summary =
            "Bilinear patches: surfaces through four corners each, flat where the corners lie in a plane.",
        .parameters =
            {arrayParameter(ParameterType::INTEGER, "indices", 0, "",
                            "vertex indices, four for each patch, at (u, v) = (0,0), (1,0), (0,1), (1,1); "
                            "not needed with four positions")
                 .range(0, std::numeric_limits<int>::max()),
             arrayParameter(ParameterType::POINT3, "P", 0, "", "positions of the corners").require(),
             arrayParameter(ParameterType::NORMAL, "N", 0, "",
                            "normals at the corners, interpolated for shading"),
             arrayParameter(ParameterType::POINT2, "uv", 0, "", "texture coordinates at the corners"),
             ignoredParameter(ParameterType::STRING, "emissionfilename",
                              "pbrt's sampling of the area light's \"filename\""),
             ignoredParameter(ParameterType::INTEGER, "faceIndices", "face numbers for Ptex textures")},
        .examples = {"\"point3 P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]",
                     "\"point3 P\" [0 0 0  1 0 .3  0 1 .4  1.2 1.1 -.2] \"point2 uv\" [0 0 1 0 0 2 1 2]",
                     "\"integer indices\" [0 1 2 3 1 4 3 5] "
                     "\"point3 P\" [0 0 0  1 0 0  0 1 .5  1 1 0  2 0 .2  2.5 1 0] "
                     "\"normal N\" [0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1]"}},
       makeBilinearMesh});
}

} // namespace recurse
