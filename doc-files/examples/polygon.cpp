/** @file
 * A flat regular polygon in the plane z = 0.
 */
#include <cmath>
#include <numbers>

#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** In a plane of its own, whose corners lie on the unit circle; `axisX` and `axisY` are its axes in the
 * scene. */
class Polygon final : public Shape {
 public:
  Polygon(int sides, double radius, const ShapeContext& context)
      : sides(sides), half(std::numbers::pi / sides),
        center(transformPoint(context.sceneFromObject, Vec3d(0))),
        axisX(Vec3d(context.sceneFromObject[0]) * radius), axisY(Vec3d(context.sceneFromObject[1]) * radius) {
    const Vec3d across = glm::cross(axisX, axisY);
    const double parallelogram = glm::length(across);
    normal = across / parallelogram;
    planeX =
        glm::cross(axisY, normal) / parallelogram; // dual to the axes: planeX · axisX = 1, planeX · axisY = 0
    planeY = glm::cross(normal, axisX) / parallelogram;
    if (swapsHandedness(context.sceneFromObject) != context.reverseOrientation) outside = -1;
    wholeArea = static_cast<float>(sides * std::sin(half) * std::cos(half) * parallelogram);
  }

  uint32_t primitiveCount() const override { return 1; }

  Bounds3f bounds(uint32_t) const override {
    const Vec3d extent = glm::sqrt(axisX * axisX + axisY * axisY); // of the circle
    return roundedOut({center - extent, center + extent});
  }

  std::optional<PrimitiveHit> intersect(uint32_t, const Vec3f& origin, const Vec3f& direction, float tMin,
                                        float tMax) const override {
    const Vec3d o = Vec3d(origin) - center, d = direction;
    const double slope = glm::dot(normal, d);
    if (slope == 0) return {};
    const double t = -glm::dot(normal, o) / slope;
    if (!(float(t) > tMin && float(t) < tMax)) return {};
    const Vec3d p = o + d * t;
    const Vec2d place(glm::dot(planeX, p), glm::dot(planeY, p));
    if (!isInside(place)) return {};
    return PrimitiveHit{float(t), HitParameters(Vec2f(place))};
  }

  SurfacePoint surfaceAt(uint32_t, const HitParameters& parameters) const override {
    const Vec2d place = parameters.uv;
    const Vec3d position = center + axisX * place.x + axisY * place.y;
    SurfacePoint s;
    s.position = Vec3f(position);
    s.geometricNormal = s.shadingNormal = Vec3f(normal * outside);
    // Rounding error: a few units of double precision, and the offset that a grazing ray needs.
    const Vec3d extent = 2.0 * glm::sqrt(axisX * axisX + axisY * axisY);
    s.error = positionError(position, 0x1p-50 * (glm::abs(axisX) + glm::abs(axisY) + glm::abs(center)),
                            normal, flatOffset(extent, position, normal));
    s.dpdu = Vec3f(axisX * 2.0);
    s.dpdv = Vec3f(axisY * 2.0);
    s.uv = Vec2f(place * 0.5 + 0.5);
    return s;
  }

  float area() const override { return wholeArea; }

  /** One of the triangles around the middle, then a point of it. */
  ShapeSample sampleArea(float, const Vec2f& u) const override {
    const double turned = double(u.x) * sides, triangle = std::min(std::floor(turned), sides - 1.0);
    const double along = (turned - triangle) * 2 - 1; // on the edge, -1 and 1 at its corners
    const double outward = std::sqrt(double(u.y));
    const Vec2d inTriangle = Vec2d(std::cos(half), along * std::sin(half)) * outward;
    const double angle = (2 * triangle + 1) * half, c = std::cos(angle), s = std::sin(angle);
    const Vec2d place(c * inTriangle.x - s * inTriangle.y, s * inTriangle.x + c * inTriangle.y);
    return {surfaceAt(0, HitParameters(Vec2f(place))), 1 / wholeArea, 0};
  }

 private:
  bool isInside(const Vec2d& place) const {
    const double angle =
        std::remainder(std::atan2(place.y, place.x) - half, 2 * half); // from the nearest edge's middle
    return glm::length(place) * std::cos(angle) < std::cos(half);
  }

  int sides;
  double half; ///< of the angle that an edge is seen under from the middle [radians]
  Vec3d center, axisX, axisY, normal, planeX, planeY;
  double outside = 1; ///< -1 where the normal points inside
  float wholeArea;
};

} // namespace

void registerPolygon(PlugIns& plugIns) {
  plugIns.shapes.add(
      {{.name = "polygon",
        .summary = "A flat regular polygon in the plane z = 0.",
        .parameters = {integerParameter("sides", "6", "how many sides").range(3, 1000),
                       realParameter("radius", "1", "of the circle through the corners").positive()},
        .examples = {"", "\"integer sides\" 3 \"float radius\" 0.5"}},
       [](const Parameters& p, const ShapeContext& c) {
         return std::make_unique<Polygon>(p.integer("sides"), p.real("radius"), c);
       }});
}

} // namespace recurse
