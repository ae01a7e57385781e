/** @file
 * Thin curves: control points for Embree, and the surface at its hits.
 */
#include "recurse/model/shape/curveShape.h"

namespace recurse {

namespace {

/** Normalised component of v perpendicular to unit n; any perpendicular where it vanishes. */
Vec3d perpendicular(const Vec3d& v, const Vec3d& n) {
  const Vec3d across = v - n * glm::dot(v, n);
  const double length = glm::length(across);
  if (length > 1e-9 * glm::length(v)) return across / length;
  return glm::normalize(glm::cross(n, std::abs(n.x) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)));
}

} // namespace

CurveShape::CurveShape(const std::vector<Segment>& segments, Kind kind, const ShapeContext& context)
    : curveKind(kind), side(context.reverseOrientation ? -1.0f : 1.0f) {
  const Mat4d& m = context.sceneFromObject;
  const Mat3d normalFromObject = glm::transpose(glm::inverse(Mat3d(m)));
  // A width has no direction: it scales by the geometric mean of the scales.
  const double scale = std::cbrt(std::abs(glm::determinant(Mat3d(m))));
  for (const Segment& s : segments) {
    for (int i = 0; i < 4; ++i) {
      const double u = i / 3.0;
      points.emplace_back(Vec3f(transformPoint(m, s.controls[i])),
                          0.5 * scale * (s.width0 * (1 - u) + s.width1 * u));
      if (!isFinite(Vec3f(points.back()))) throw Error("a position is too large for single precision");
    }
  }
  if (kind == Kind::RIBBON)
    for (const Segment& s : segments)
      for (const Vec3d& n : {s.normal0, s.normal1}) ends.push_back(glm::normalize(normalFromObject * n));
}

CurveShape::Place CurveShape::placeOn(uint32_t segment, double u) const {
  const glm::dvec4 p0 = points[4 * segment], p1 = points[4 * segment + 1], p2 = points[4 * segment + 2],
                   p3 = points[4 * segment + 3];
  const double v = 1 - u;
  const glm::dvec4 p = p0 * (v * v * v) + p1 * (3 * u * v * v) + p2 * (3 * u * u * v) + p3 * (u * u * u);
  Vec3d tangent((p1 - p0) * (3 * v * v) + (p2 - p1) * (6 * u * v) + (p3 - p2) * (3 * u * u));
  if (!(glm::dot(tangent, tangent) > 0)) tangent = Vec3d(p3 - p0); // coincident control points
  if (!(glm::dot(tangent, tangent) > 0)) tangent = Vec3d(0, 0, 1);
  return {Vec3d(p), tangent, p.w};
}

std::optional<HitParameters> CurveShape::parametersOf(uint32_t segment, float u, const Vec3f& origin,
                                                      const Vec3f& direction, float t) const {
  const Place c = placeOn(segment, double(u));
  const Vec3d along = glm::normalize(c.tangent), d(direction);
  Vec3d normal = perpendicular(-d, along);
  const Vec3d across = glm::cross(along, normal), met = Vec3d(origin) + d * double(t);
  double v = c.radius > 0 ? std::clamp(glm::dot(met - c.position, across) / c.radius, -1.0, 1.0) : 0;
  // The cosine of normal and ray narrows a ribbon, as in pbrt-v4. The normal is made perpendicular to the
  // curve first, as that of the surface is: with another one, photons would arrive at a surface cosine of
  // zero, where hair divides by it.
  if (curveKind == Kind::RIBBON) {
    const Vec3d n0 = ends[2 * segment], n1 = ends[2 * segment + 1];
    const double angle = std::acos(std::clamp(glm::dot(n0, n1), -1.0, 1.0)), sine = std::sin(angle);
    const Vec3d turned =
        sine > 1e-6 ? (n0 * std::sin((1 - double(u)) * angle) + n1 * std::sin(double(u) * angle)) / sine : n0;
    normal = perpendicular(turned, along);
    const double narrowed = std::abs(glm::dot(normal, d)) / glm::length(d);
    if (std::abs(v) > narrowed) return {};
    v = narrowed > 0 ? v / narrowed : 0;
    if (glm::dot(glm::cross(along, normal), across) < 0) v = -v;
  }
  return HitParameters({u, static_cast<float>(v)}, Vec3f(normal));
}

Bounds3f CurveShape::bounds(uint32_t segment) const {
  Bounds3d b;
  for (uint32_t i = 4 * segment; i < 4 * segment + 4; ++i) {
    b.add(Vec3d(points[i]) - double(points[i].w));
    b.add(Vec3d(points[i]) + double(points[i].w));
  }
  return roundedOut(b);
}

std::optional<PrimitiveHit> CurveShape::intersect(uint32_t, const Vec3f&, const Vec3f&, float, float) const {
  throw std::logic_error("curves are intersected by Embree");
}

/** Surface at the parameters u along the segment, v in [-1, 1] across, flat normal; as in pbrt-v4. */
SurfacePoint CurveShape::surfaceAt(uint32_t segment, const HitParameters& parameters) const {
  const Place c = placeOn(segment, double(parameters.uv.x));
  const double v = double(parameters.uv.y);
  const Vec3d along = glm::normalize(c.tangent), flat(parameters.normal), across = glm::cross(along, flat);
  Vec3d normal = flat, dpdv = across;
  if (curveKind == Kind::CYLINDER) {
    const double theta = 0.5 * double(PI) * v;
    // Normals turn inwards as in pbrt-v4, while a tube's would turn outwards.
    normal = flat * std::cos(theta) - across * std::sin(theta);
    dpdv = across * std::cos(theta) + flat * std::sin(theta);
  }
  const double segments = primitiveCount();
  SurfacePoint s;
  s.position = Vec3f(c.position + across * (v * c.radius));
  s.geometricNormal = s.shadingNormal = Vec3f(glm::normalize(normal)) * side;
  // A flat curve faces each ray: the error makes the next ray start beyond its width.
  s.error = Vec3f(static_cast<float>(2 * c.radius)) + magnitude(s.position) * 0x1p-22f;
  s.curve = curveKind == Kind::RIBBON ? SurfacePoint::Curve::FIXED : SurfacePoint::Curve::FACES_RAY;
  s.dpdu = Vec3f(c.tangent * segments);
  s.dpdv = Vec3f(dpdv * (2 * c.radius));
  s.uv = {static_cast<float>((segment + double(parameters.uv.x)) / segments),
          static_cast<float>(0.5 + 0.5 * v)};
  return s;
}

} // namespace recurse
