/** @file
 * Spheres, and ellipsoids by their transforms, whole or swept in part. Computations are in double precision
 * on the unit sphere, which an affine map takes to the scene.
 */
#include <mutex>

#include "recurse/core/math/integrate.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Part of the unit sphere that the shape covers. */
struct Sweep {
  double zLow = -1, zHigh = 1, phiMax = 2 * PI_D;
  bool whole() const { return zLow <= -1 && zHigh >= 1 && phiMax >= 2 * PI_D; }
  double solidAngle() const { return phiMax * (zHigh - zLow); }
};

double azimuth(const Vec3d& d) {
  const double phi = std::atan2(d.y, d.x);
  return phi < 0 ? phi + 2 * PI_D : phi;
}

class Sphere final : public Shape {
 public:
  Sphere(double radius, const Sweep& sweep, const ShapeContext& context)
      : linear(Mat3d(context.sceneFromObject) * radius), inverse(glm::inverse(linear)),
        center(context.sceneFromObject[3]), sweep(sweep), thetaLow(std::acos(sweep.zLow)),
        thetaHigh(std::acos(sweep.zHigh)), determinant(std::abs(glm::determinant(linear))),
        side(context.reverseOrientation ? -1 : 1) {
    for (int i = 0; i < 3; ++i) {
      magnitude[i] = glm::abs(linear[i]);
      inverseMagnitude[i] = glm::abs(inverse[i]);
    }
    // Bound on the double-precision rounding error of a transform to the unit sphere and back.
    const Vec3d there = inverseMagnitude * (magnitude * Vec3d(1));
    unitError = 0x1p-50 * std::max(there.x, std::max(there.y, there.z));
    // Tests for a rotation with uniform scale, up to the rounding of numbers in the file.
    const Mat3d gram = glm::transpose(linear) * linear;
    uniformRadius = std::cbrt(determinant);
    const double r2 = square(uniformRadius);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        if (!(std::abs(gram[i][k] - (i == k ? r2 : 0)) <= 1e-9 * r2)) uniformRadius = 0;
  }

  uint32_t primitiveCount() const override { return 1; }

  Bounds3f bounds(uint32_t) const override {
    Bounds3d box;
    Vec3d extent;
    for (int i = 0; i < 3; ++i)
      extent[i] = std::sqrt(square(linear[0][i]) + square(linear[1][i]) + square(linear[2][i]));
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
                 linear * Vec3d(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z));
      box.lower = glm::max(box.lower, part.lower);
      box.upper = glm::min(box.upper, part.upper);
    }
    return roundedOut(box);
  }

  std::optional<PrimitiveHit> intersect(uint32_t, const Vec3f& origin, const Vec3f& direction, float tMin,
                                        float tMax) const override {
    const Vec3d o = inverse * (Vec3d(origin) - center), d = inverse * Vec3d(direction);
    double ts[2];
    if (!intersectLine(o, d, ts)) return {};
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
    return placeAt(glm::normalize(Vec3d(parameters.point())));
  }

  float area() const override {
    if (uniformRadius > 0) return static_cast<float>(sweep.solidAngle() * square(uniformRadius));
    // The area is computed on demand: it is slow, and only the power of lights needs it.
    std::call_once(areaKnown, [this] { ellipsoidArea = stretchedArea(); });
    return static_cast<float>(ellipsoidArea);
  }

  std::unique_ptr<Solid> asSolid() const override {
    if (!sweep.whole()) throw Error("it is only a part of a sphere (zmin, zmax or phimax)");
    return std::make_unique<WholeSphere>(*this);
  }

  std::vector<RimPiece> rim() const override {
    const auto point = [&](double u, double v) { return center + linear * unitPointAt(u, v); };
    const bool isPartial = sweep.phiMax < 2 * PI_D;
    const bool isCutBelow = sweep.zLow > -1;
    return rimOfSweep(point, isPartial, isCutBelow, sweep.zHigh < 1);
  }

  uint32_t faceCount() const override { return 1; }
  SurfacePoint pointOnFace(const FacePoint& p) const override { return pointAt(unitPointAt(p.uv.x, p.uv.y)); }
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
    if (uniformRadius > 0) return 1 / area();
    const Vec3d normal = point.geometricNormal;
    return static_cast<float>(glm::length(glm::transpose(linear) * normal) /
                              (sweep.solidAngle() * determinant));
  }

  std::optional<ShapeSample> pointWithNormal(const Vec3f& normal) const override {
    std::optional<ShapeSample> s;
    if (!(uniformRadius > 0 && sweep.whole())) return s;
    s.emplace();
    s->point = pointAt(glm::normalize(inverse * (Vec3d(normal) * (side * uniformRadius))));
    s->pdf = pdfArea(0, s->point);
    return s;
  }

  std::optional<ShapeSample> sampleDirection(const Vec3f& from, float pick, const Vec2f& u) const override {
    const Vec3d away = Vec3d(from) - center;
    const double distance2 = glm::dot(away, away);
    if (!coneIsSeen(from, distance2)) return Shape::sampleDirection(from, pick, u);
    // Uniform in the cone around the sphere, in terms of 1 - cosine, which is precise at any distance.
    const double sin2Max = square(uniformRadius) / distance2;
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
    s.point = pointAt(glm::normalize(inverse * (normal * uniformRadius)));
    s.pdf = conePdf(sin2Max);
    return s;
  }

  float pdfDirection(const Vec3f& from, uint32_t primitive, const SurfacePoint& point) const override {
    const Vec3d away = Vec3d(from) - center;
    const double distance2 = glm::dot(away, away);
    return coneIsSeen(from, distance2) ? conePdf(square(uniformRadius) / distance2)
                                       : Shape::pdfDirection(from, primitive, point);
  }

 private:
  /** Intersections of a line with the unit sphere, the nearer one first. */
  static bool intersectLine(const Vec3d& o, const Vec3d& d, double (&t)[2]) {
    const double a = glm::dot(d, d), b = glm::dot(o, d), c = glm::dot(o, o) - 1;
    if (!(a > 0)) return false;
    // Discriminant from the point of the ray nearest to the centre, which keeps its precision when the
    // sphere is small and far (Haines et al., "Precision Improvements for Ray/Sphere Intersection",
    // 2019).
    const Vec3d nearest = o - d * (b / a);
    double discriminant = 1 - glm::dot(nearest, nearest);
    if (c < 0) discriminant = std::max(discriminant, 0.0);
    if (!(discriminant >= 0)) return false;
    const double root = std::sqrt(discriminant * a);
    const double q = b < 0 ? root - b : -b - root;
    t[0] = q / a;
    t[1] = q != 0 ? c / q : 0;
    if (t[0] > t[1]) std::swap(t[0], t[1]);
    return true;
  }

  class WholeSphere final : public Solid {
   public:
    explicit WholeSphere(const Sphere& sphere) : sphere(sphere) {}
    void crossings(const Vec3d& origin, const Vec3d& direction, std::vector<Crossing>& found) const override {
      const Vec3d o = sphere.inverse * (origin - sphere.center), d = sphere.inverse * direction;
      double t[2];
      if (!intersectLine(o, d, t)) return;
      for (int i = 0; i < 2; ++i)
        found.push_back({t[i], i == 0, 0, HitParameters(Vec3f(glm::normalize(o + d * t[i])))});
    }
    bool normalsPointIn() const override { return sphere.side < 0; }

   private:
    const Sphere& sphere;
  };

  /** Whether `from` is clearly outside. Points of the sphere itself are rounded to either side of it, and
   * do not count as outside. */
  bool coneIsSeen(const Vec3f& from, double distance2) const {
    const double surface = uniformRadius * (1 + 1e-4) + 1e-6 * glm::length(Vec3d(from));
    return uniformRadius > 0 && sweep.whole() && distance2 > square(surface);
  }
  static double oneMinusCosine(double sin2) { return sin2 / (1 + std::sqrt(1 - sin2)); }
  static float conePdf(double sin2Max) {
    return static_cast<float>(1 / (2 * PI_D * oneMinusCosine(sin2Max)));
  }

  /** Point of the unit sphere at (u, v). */
  Vec3d unitPointAt(double u, double v) const {
    const double theta = thetaLow + (thetaHigh - thetaLow) * v, phi = sweep.phiMax * u;
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
  }

  SurfacePoint placeAt(const Vec3d& unit) const {
    SurfacePoint s;
    const Vec3d position = center + linear * unit;
    const Vec3d gradient = glm::transpose(inverse) * unit;
    const double steepness = glm::length(gradient);
    const Vec3d normal = gradient * (side / steepness);
    s.position = Vec3f(position);
    s.geometricNormal = s.shadingNormal = Vec3f(normal);

    const Vec3d exactError = 0x1p-50 * (magnitude * glm::abs(unit) + glm::abs(center));
    s.error = positionError(position, exactError, normal, unitError / steepness);
    return s;
  }

  SurfacePoint pointAt(const Vec3d& unit) const {
    SurfacePoint s = placeAt(unit);
    // Coordinates of pbrt: around in u, from zmin up to zmax in v.
    const double rho = std::hypot(unit.x, unit.y), theta = std::atan2(rho, unit.z);
    s.uv = {static_cast<float>(std::min(azimuth(unit) / sweep.phiMax, 1.0)),
            static_cast<float>(std::clamp((theta - thetaLow) / (thetaHigh - thetaLow), 0.0, 1.0))};
    const Vec2d outwards = rho > 0 ? Vec2d(unit) / rho : Vec2d(1, 0);
    const Vec3d dpdu = Vec3d(-unit.y, unit.x, 0) * sweep.phiMax,
                dpdv = Vec3d(outwards * unit.z, -rho) * (thetaHigh - thetaLow);
    s.dpdu = Vec3f(linear * dpdu);
    s.dpdv = Vec3f(linear * dpdv);
    // The unit sphere's normal is its position.
    const Vec3d gradient = glm::transpose(inverse) * unit;
    s.dndu = derivativeOfUnit(gradient, glm::transpose(inverse) * dpdu, side);
    s.dndv = derivativeOfUnit(gradient, glm::transpose(inverse) * dpdv, side);
    return s;
  }

  /** Integral of the map's area stretch over the part of the unit sphere. */
  double stretchedArea() const {
    const Mat3d cofactor = glm::transpose(inverse) * determinant;
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

  Mat3d linear, inverse; ///< between the unit sphere and the scene
  Vec3d center;
  Sweep sweep;
  double thetaLow, thetaHigh;        ///< polar angles of the sweep, from the z axis
  Mat3d magnitude, inverseMagnitude; ///< absolute values of the matrices
  double determinant;
  double side;              ///< -1 where the inside counts as outside
  double unitError;         ///< bound on the rounding error of a point taken to the unit sphere
  double uniformRadius = 0; ///< 0 for ellipsoids
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
