/** @file
 * Spheres, and ellipsoids by their transforms, whole or swept in part. Computations are in double precision
 * on the unit sphere, which an affine map takes to the scene.
 */
#include <mutex>

#include "recurse/core/math/integrate.h"
#include "recurse/model/scene/plugIns.h"
#include "shapes/analytic/ellipsoid.h"

namespace recurse {

namespace {

/** Part of the unit sphere that the shape covers. */
struct Sweep {
  double zLow = -1, zHigh = 1, phiMax = 2 * PI_D;
  bool whole() const { return zLow <= -1 && zHigh >= 1 && phiMax >= 2 * PI_D; }
  double solidAngle() const { return phiMax * (zHigh - zLow); }
};

class Sphere final : public Shape {
 public:
  Sphere(double radius, const Sweep& sweep, const ShapeContext& context)
      : map(Mat3d(context.sceneFromObject) * radius, context.reverseOrientation),
        center(context.sceneFromObject[3]),
        sweep(sweep), angles{sweep.phiMax, std::acos(sweep.zLow), std::acos(sweep.zHigh)} {}

  uint32_t primitiveCount() const override { return 1; }

  Bounds3f bounds(uint32_t) const override {
    Bounds3d box;
    const Vec3d extent = map.extent();
    box.lower = center - extent;
    box.upper = center + extent;
    if (!sweep.whole()) {
      // Bounding box of the part of the unit sphere, with slack because points come from rounded parameters.
      const double lowest = std::min(std::abs(sweep.zLow), std::abs(sweep.zHigh));
      const double r = sweep.zLow <= 0 && sweep.zHigh >= 0 ? 1 : std::sqrt(1 - square(lowest));
      const double c = std::cos(sweep.phiMax), s = std::sin(sweep.phiMax), phi = sweep.phiMax;
      const Vec3d slack(0x1p-20);
      const Vec3d low = Vec3d(phi >= PI_D ? -r : std::min(0.0, r * c),
                              phi >= 1.5 * PI_D ? -r : std::min(0.0, r * s), sweep.zLow) -
                        slack;
      const Vec3d high = Vec3d(r, phi >= 0.5 * PI_D ? r : r * s, sweep.zHigh) + slack;
      Bounds3d part;
      for (int i = 0; i < 8; ++i)
        part.add(center +
                 map.linear * Vec3d(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z));
      box.lower = glm::max(box.lower, part.lower);
      box.upper = glm::min(box.upper, part.upper);
    }
    return roundedOut(box);
  }

  std::optional<PrimitiveHit> intersect(uint32_t, const Vec3f& origin, const Vec3f& direction, float tMin,
                                        float tMax) const override {
    const Vec3d o = map.inverse * (Vec3d(origin) - center), d = map.inverse * Vec3d(direction);
    double ts[2];
    if (!intersectUnitSphere(o, d, ts)) return {};
    for (const double t : ts) {
      const auto rounded = static_cast<float>(t);
      if (!(rounded > tMin && rounded < tMax)) continue;
      const Vec3d p = glm::normalize(o + d * t);
      if (!sweep.whole() && (p.z < sweep.zLow || p.z > sweep.zHigh || azimuth(p) > sweep.phiMax)) continue;
      return PrimitiveHit{rounded, HitParameters(Vec3f(p))};
    }
    return {};
  }

  /** Hit parameters are the point on the unit sphere. */
  SurfacePoint surfaceAt(uint32_t, const HitParameters& parameters) const override {
    return pointAt(glm::normalize(Vec3d(parameters.point())));
  }
  SurfacePoint placeAt(uint32_t, const HitParameters& parameters) const override {
    return map.placeAt(center, 1, glm::normalize(Vec3d(parameters.point())));
  }

  float area() const override {
    if (map.uniformScale > 0) return static_cast<float>(sweep.solidAngle() * square(map.uniformScale));
    // The area is computed on demand: it is slow, and only the power of lights needs it.
    std::call_once(areaKnown, [this] { ellipsoidArea = stretchedArea(); });
    return static_cast<float>(ellipsoidArea);
  }

  std::unique_ptr<Solid> asSolid() const override {
    if (!sweep.whole()) throw Error("it is only a part of a sphere (zmin, zmax or phimax)");
    return std::make_unique<WholeSphere>(*this);
  }

  std::vector<RimPiece> rim() const override {
    const auto point = [&](double u, double v) { return center + map.linear * angles.pointAt(u, v); };
    const bool isPartial = sweep.phiMax < 2 * PI_D;
    const bool isCutBelow = sweep.zLow > -1;
    return rimOfSweep(point, isPartial, isCutBelow, sweep.zHigh < 1);
  }

  uint32_t faceCount() const override { return 1; }
  SurfacePoint pointOnFace(const FacePoint& p) const override {
    return pointAt(angles.pointAt(p.uv.x, p.uv.y));
  }
  FacePoint facePointOf(uint32_t, const SurfacePoint& point) const override { return {0, point.uv}; }

  ShapeSample sampleArea(float, const Vec2f& u) const override {
    const double z = sweep.zLow + (sweep.zHigh - sweep.zLow) * double(u.x), phi = sweep.phiMax * double(u.y);
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    ShapeSample s;
    s.point = pointAt({r * std::cos(phi), r * std::sin(phi), z});
    s.pdf = pdfArea(0, s.point);
    return s;
  }

  /** Points are uniform on the unit sphere, so that the area stretch of the map divides their density. */
  float pdfArea(uint32_t, const SurfacePoint& point) const override {
    if (map.uniformScale > 0) return 1 / area();
    const Vec3d normal = point.geometricNormal;
    return static_cast<float>(glm::length(glm::transpose(map.linear) * normal) /
                              (sweep.solidAngle() * map.determinant));
  }

  std::optional<ShapeSample> sampleDirection(const Vec3f& from, float pick, const Vec2f& u) const override {
    const Vec3d away = Vec3d(from) - center;
    const double distance2 = glm::dot(away, away);
    if (!coneIsSeen(from, distance2)) return Shape::sampleDirection(from, pick, u);
    // Uniform in the cone around the sphere, in terms of 1 - cosine, which is precise at any distance.
    const double sin2Max = square(map.uniformScale) / distance2;
    const double x = double(u.x) * oneMinusCosine(sin2Max);
    const double sin2 = x * (2 - x), cosine = 1 - x;
    // Angle at the sphere's centre between the directions to `from` and to the point that the ray hits.
    const double cosAlpha = sin2 / std::sqrt(sin2Max) + cosine * std::sqrt(std::max(0.0, 1 - sin2 / sin2Max));
    const double sinAlpha = std::sqrt(std::max(0.0, 1 - square(cosAlpha)));
    const double phi = 2 * PI_D * double(u.y);
    const Vec3d z = away / std::sqrt(distance2);
    const Vec3d unlike = std::abs(z.x) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
    const Vec3d tangent = glm::normalize(glm::cross(z, unlike)), bitangent = glm::cross(z, tangent);
    const Vec3d normal =
        z * std::min(cosAlpha, 1.0) + (tangent * std::cos(phi) + bitangent * std::sin(phi)) * sinAlpha;
    ShapeSample s;
    s.point = pointAt(glm::normalize(map.inverse * (normal * map.uniformScale)));
    s.pdf = conePdf(sin2Max);
    return s;
  }

  float pdfDirection(const Vec3f& from, uint32_t primitive, const SurfacePoint& point) const override {
    const Vec3d away = Vec3d(from) - center;
    const double distance2 = glm::dot(away, away);
    if (!coneIsSeen(from, distance2)) return Shape::pdfDirection(from, primitive, point);
    // Rays through an alpha texture or a thin pane hit the far side, where sampleDirection() has no points.
    const double radius2 = square(map.uniformScale);
    return glm::dot(away, Vec3d(point.position) - center) < radius2 ? 0 : conePdf(radius2 / distance2);
  }

 private:
  class WholeSphere final : public Solid {
   public:
    explicit WholeSphere(const Sphere& sphere) : sphere(sphere) {}
    void crossings(const Vec3d& origin, const Vec3d& direction, std::vector<Crossing>& found) const override {
      const Vec3d o = sphere.map.inverse * (origin - sphere.center), d = sphere.map.inverse * direction;
      double t[2];
      if (!intersectUnitSphere(o, d, t)) return;
      for (int i = 0; i < 2; ++i)
        found.push_back({t[i], i == 0, 0, HitParameters(Vec3f(glm::normalize(o + d * t[i])))});
    }
    bool normalsPointIn() const override { return sphere.map.side < 0; }

   private:
    const Sphere& sphere;
  };

  /** Whether `from` is clearly outside. Points of the sphere itself are rounded to either side of it, and
   * do not count as outside. */
  bool coneIsSeen(const Vec3f& from, double distance2) const {
    const double surface = map.uniformScale * (1 + 1e-4) + 1e-6 * glm::length(Vec3d(from));
    return map.uniformScale > 0 && sweep.whole() && distance2 > square(surface);
  }
  static double oneMinusCosine(double sin2) { return sin2 / (1 + std::sqrt(1 - sin2)); }
  static float conePdf(double sin2Max) {
    return static_cast<float>(1 / (2 * PI_D * oneMinusCosine(sin2Max)));
  }

  SurfacePoint pointAt(const Vec3d& unit) const { return map.pointAt(center, 1, unit, angles); }

  /** Integral of the map's area stretch over the part of the unit sphere. */
  double stretchedArea() const {
    const Mat3d cofactor = glm::transpose(map.inverse) * map.determinant;
    return integrate(
        [&](double z) {
          const double r = std::sqrt(std::max(0.0, 1 - z * z));
          return integrate(
              [&](double phi) {
                return glm::length(cofactor * Vec3d(r * std::cos(phi), r * std::sin(phi), z));
              },
              0, sweep.phiMax, 1e-8);
        },
        sweep.zLow, sweep.zHigh, 1e-7);
  }

  EllipsoidMap map;
  Vec3d center;
  Sweep sweep;
  SphereAngles angles;
  mutable std::once_flag areaKnown;
  mutable double ellipsoidArea = 0;
};

std::unique_ptr<Shape> makeSphere(const Parameters& p, const ShapeContext& context) {
  const double radius = p.real("radius");
  double zMin = p.hasValue("zmin") ? p.real("zmin") : -radius;
  double zMax = p.hasValue("zmax") ? p.real("zmax") : radius;
  if (zMin > zMax) std::swap(zMin, zMax); // as in pbrt
  Sweep sweep;
  // Beyond the poles there is nothing to cut off.
  sweep.zLow = std::clamp(zMin / radius, -1.0, 1.0);
  sweep.zHigh = std::clamp(zMax / radius, -1.0, 1.0);
  sweep.phiMax = p.real("phimax") / 360 * (2 * PI_D);
  if (!(sweep.zLow < sweep.zHigh))
    p.fail(p.has("zmin") ? "zmin" : "zmax", "no part of the sphere is between zmin and zmax",
           "zmin < zmax, both between -radius and radius");
  return std::make_unique<Sphere>(radius, sweep, context);
}

} // namespace

void registerSphere(PlugIns& plugIns) {
  ParameterSpec sweep = realParameter("phimax", "360", "angle of the sector around the z axis [degrees]");
  sweep.positive().maximum = 360;
  plugIns.shapes.add(
      {{.name = "sphere",
        .summary = "A sphere around the origin, or a part of it; transforms change it to ellipsoids.",
        .parameters = {realParameter("radius", "1", "radius").positive(),
                       realParameter("zmin", "", "lower end of the surface; by default -radius"),
                       realParameter("zmax", "", "upper end of the surface; by default radius"), sweep},
        .examples = {"", "\"float radius\" 0.5",
                     "\"float radius\" 2 \"float zmin\" -1.5 \"float zmax\" 1 \"float phimax\" 200"}},
       makeSphere});
}

} // namespace recurse
