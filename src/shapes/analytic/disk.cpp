/** @file
 * Discs, rings and sectors of them; transforms make ellipses. Computed in double precision.
 */
#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

constexpr double TWO_PI = 6.28318530717958647693;

class Disk final : public Shape {
 public:
  /** `inner` is the ratio of the radii of hole and disc. */
  Disk(double height, double radius, double inner, double phiMax, const ShapeContext& context)
      : center(transformPoint(context.sceneFromObject, {0, 0, height})),
        axisX(Vec3d(context.sceneFromObject[0]) * radius), axisY(Vec3d(context.sceneFromObject[1]) * radius),
        inner(inner), phiMax(phiMax) {
    const Vec3d across = glm::cross(axisX, axisY);
    const double parallelogram = glm::length(across);
    normal = across / parallelogram;
    coordinateX = glm::cross(axisY, normal) / parallelogram;
    coordinateY = glm::cross(normal, axisX) / parallelogram;
    // The outer side is +z of object space, whatever the transform.
    if (swapsHandedness(context.sceneFromObject) != context.reverseOrientation) outside = -1;
    totalArea = static_cast<float>(0.5 * phiMax * (1 - square(inner)) * parallelogram);
  }

  uint32_t primitiveCount() const override { return 1; }

  Bounds3f bounds(uint32_t) const override {
    const Vec3d extent = glm::sqrt(axisX * axisX + axisY * axisY);
    return roundedOut({center - extent, center + extent});
  }

  std::optional<PrimitiveHit> intersect(uint32_t, const Vec3f& origin, const Vec3f& direction, float tMin,
                                        float tMax) const override {
    const Vec3d o = Vec3d(origin) - center, d = direction;
    const double slope = glm::dot(normal, d);
    if (slope == 0) return {};
    const double t = -glm::dot(normal, o) / slope;
    const auto rounded = static_cast<float>(t);
    if (!(rounded > tMin && rounded < tMax)) return {};
    const Vec3d p = o + d * t;
    const double x = glm::dot(coordinateX, p), y = glm::dot(coordinateY, p), r2 = x * x + y * y;
    if (r2 > 1 || r2 < square(inner)) return {};
    if (phiMax < TWO_PI && azimuth(x, y) > phiMax) return {};
    return PrimitiveHit{rounded, HitParameters(Vec2f(x, y))};
  }

  /** Hit parameters are coordinates on the unit disc. */
  SurfacePoint surfaceAt(uint32_t, const HitParameters& parameters) const override {
    double x = double(parameters.uv.x), y = double(parameters.uv.y);
    double r = std::sqrt(square(x) + square(y));
    if (r > 1) { // outside by rounding
      x /= r;
      y /= r;
      r = 1;
    }
    SurfacePoint s;
    const Vec3d across = axisX * x + axisY * y, position = center + across;
    s.position = Vec3f(position);
    s.geometricNormal = s.shadingNormal = Vec3f(normal * outside);
    const Vec3d extent = 2.0 * glm::sqrt(axisX * axisX + axisY * axisY);
    s.error = positionError(position, 0x1p-50 * (glm::abs(axisX) + glm::abs(axisY) + glm::abs(center)),
                            normal, flatOffset(extent, position, normal));
    s.dpdu = Vec3f((axisY * x - axisX * y) * phiMax);
    s.dpdv = Vec3f((r > 0 ? (axisX * x + axisY * y) / r : axisX) * (inner - 1));
    s.uv = {static_cast<float>(std::min(azimuth(x, y) / phiMax, 1.0)),
            static_cast<float>(std::clamp((1 - r) / (1 - inner), 0.0, 1.0))};
    return s;
  }

  float area() const override { return totalArea; }

  std::vector<RimPiece> rim() const override {
    const auto point = [&](double u, double v) {
      const Vec2d p = unitPointAt(u, 1 - v);
      return center + axisX * p.x + axisY * p.y;
    };
    const bool isPartial = phiMax < TWO_PI;
    const bool hasHole = inner > 0;
    return rimOfSweep(point, isPartial, hasHole, true);
  }

  uint32_t faceCount() const override { return 1; }
  SurfacePoint pointOnFace(const FacePoint& p) const override {
    return surfaceAt(0, HitParameters(Vec2f(unitPointAt(p.uv.x, p.uv.y))));
  }
  FacePoint facePointOf(uint32_t, const SurfacePoint& point) const override { return {0, point.uv}; }

  ShapeSample sampleArea(float, const Vec2f& u) const override {
    ShapeSample s;
    Vec2f p;
    if (inner == 0 && phiMax >= TWO_PI) {
      p = uniformDisk(u);
    } else {
      const double r = std::sqrt(square(inner) + (1 - square(inner)) * double(u.x)),
                   phi = phiMax * double(u.y);
      p = {static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi))};
    }
    s.point = surfaceAt(0, HitParameters(p));
    s.pdf = 1 / totalArea;
    return s;
  }

 private:
  /** Point of the unit disc at (u, v). */
  Vec2d unitPointAt(double u, double v) const {
    const double r = 1 - (1 - inner) * v, phi = phiMax * u;
    return {r * std::cos(phi), r * std::sin(phi)};
  }
  static double azimuth(double x, double y) {
    const double phi = std::atan2(y, x);
    return phi < 0 ? phi + TWO_PI : phi;
  }

  Vec3d center, axisX, axisY;     ///< the unit disc's centre and axes in the scene
  Vec3d normal;                   ///< along axisX × axisY
  Vec3d coordinateX, coordinateY; ///< dual to the axes
  double inner, phiMax;
  double outside = 1; ///< -1 where the normal points inside
  float totalArea = 0;
};

std::unique_ptr<Shape> makeDisk(const Parameters& p, const ShapeContext& context) {
  const double radius = p.real("radius"), inner = p.real("innerradius");
  if (!(inner < radius))
    p.fail(p.has("innerradius") ? "innerradius" : "radius", "the hole is as large as the disc",
           "an innerradius less than the radius");
  return std::make_unique<Disk>(p.real("height"), radius, inner / radius, p.real("phimax") / 360 * TWO_PI,
                                context);
}

} // namespace

void registerDisk(PlugIns& plugIns) {
  ParameterSpec sweep = realParameter("phimax", "360", "angle of the sector around the z axis [degrees]");
  sweep.positive().maximum = 360;
  plugIns.shapes.add(
      {{.name = "disk",
        .summary = "A disc, a ring or a sector of one, perpendicular to the z axis.",
        .parameters = {realParameter("height", "0", "z coordinate of the disc"),
                       realParameter("radius", "1", "radius").positive(),
                       realParameter("innerradius", "0", "radius of the hole")
                           .range(0, std::numeric_limits<double>::infinity()),
                       sweep},
        .examples =
            {"", "\"float height\" 0.3 \"float radius\" 2 \"float innerradius\" 0.5 \"float phimax\" 250"}},
       makeDisk});
}

} // namespace recurse
