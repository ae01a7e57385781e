/** @file
 * Transforms, error bounds and area sampling of shapes that are computed in their own space.
 */
#include "shapes/analytic/mappedShape.h"

#include "recurse/core/math/integrate.h"

namespace recurse {

void MappedShape::prepare(const Mat4d& sceneFromOwn, const Bounds3d& ownBounds, std::vector<double> partAreas,
                          bool reverseOrientation, double radius) {
  linear = Mat3d(sceneFromOwn);
  inverse = glm::inverse(linear);
  center = Vec3d(sceneFromOwn[3]);
  determinant = std::abs(glm::determinant(linear));
  side = reverseOrientation ? -1 : 1;
  Mat3d inverseMagnitudes;
  for (int i = 0; i < 3; ++i) {
    magnitudes[i] = glm::abs(linear[i]);
    inverseMagnitudes[i] = glm::abs(inverse[i]);
  }
  const Vec3d half = 0.5 * ownBounds.diagonal() * (1 + 0x1p-20),
              middle = center + linear * ownBounds.center();
  const Vec3d largest = glm::max(glm::abs(ownBounds.lower), glm::abs(ownBounds.upper));
  Bounds3d bounds{middle - magnitudes * half, middle + magnitudes * half};
  if (radius > 0) { // the bounding cylinder of a surface of revolution may be tighter
    Vec3d reach = magnitudes[2] * half.z;
    for (int i = 0; i < 3; ++i) reach[i] += radius * (1 + 0x1p-20) * std::hypot(linear[0][i], linear[1][i]);
    const Vec3d onAxis = center + linear[2] * ownBounds.center().z;
    bounds.lower = glm::max(bounds.lower, onAxis - reach);
    bounds.upper = glm::min(bounds.upper, onAxis + reach);
  }
  box = roundedOut(bounds);
  extent = bounds.diagonal();
  // Bound on the rounding of coordinates and of the polynomials that are solved.
  const Vec3d there = inverseMagnitudes * (magnitudes * largest);
  roundingInOwn = 0x1p-40 * std::max(there.x, std::max(there.y, there.z));
  // Tests for a rotation with uniform scale, up to the rounding of numbers in the file.
  const Mat3d gram = glm::transpose(linear) * linear;
  uniformScale = std::cbrt(determinant);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      if (!(std::abs(gram[i][k] - (i == k ? square(uniformScale) : 0)) <= 1e-9 * square(uniformScale))) {
        uniformScale = 0;
        i = k = 3;
      }
  areas = std::move(partAreas);
  for (const double a : areas) ownArea += a;
}

std::optional<PrimitiveHit> MappedShape::intersect(uint32_t, const Vec3f& origin, const Vec3f& direction,
                                                   float tMin, float tMax) const {
  static thread_local std::vector<LineHit> storage;
  Line line = toOwn(origin, direction);
  line.tMin = double(tMin);
  line.tMax = double(tMax);
  for (const bool nearestOnly : {true, false}) {
    line.nearestOnly = nearestOnly;
    LineHits found(storage);
    intersectAll(line, found);
    for (const LineHit& m : found) {
      const auto t = static_cast<float>(m.t);
      if (t > tMin && t < tMax) return PrimitiveHit{t, HitParameters(Vec3f(m.point), m.part)};
    }
    if (found.empty()) return {}; // otherwise the nearest hit may have been rounded to tMin
  }
  return {};
}

SurfacePoint MappedShape::toScene(const OwnPoint& own) const {
  SurfacePoint s;
  const Vec3d position = center + linear * own.position;
  const Vec3d gradient = glm::transpose(inverse) * own.normal;
  const double steepness = glm::length(gradient);
  const Vec3d normal = gradient * (side / steepness);
  s.position = Vec3f(position);
  s.geometricNormal = s.shadingNormal = Vec3f(normal);
  const Vec3d exactError = 0x1p-50 * (magnitudes * glm::abs(own.position) + glm::abs(center));
  s.error =
      positionError(position, exactError, normal,
                    std::max((roundingInOwn + own.error) / steepness, flatOffset(extent, position, normal)));
  s.dpdu = Vec3f(linear * own.dpdu);
  s.dpdv = Vec3f(linear * own.dpdv);
  s.dndu = derivativeOfUnit(gradient, glm::transpose(inverse) * own.dndu, side);
  s.dndv = derivativeOfUnit(gradient, glm::transpose(inverse) * own.dndv, side);
  s.uv = Vec2f(own.uv);
  return s;
}

SurfacePoint MappedShape::surfaceAt(uint32_t, const HitParameters& parameters) const {
  return toScene(ownPoint(parameters.part(), Vec3d(parameters.point())));
}

double MappedShape::stretchedArea() const {
  // Area with unit normal n grows by the length of the cofactor matrix times n.
  const Mat3d cofactor = glm::transpose(inverse) * determinant;
  double sum = 0;
  for (uint32_t part = 0; part < areas.size(); ++part)
    sum += areas[part] * integrate(
                             [&](double v) {
                               return integrate(
                                   [&](double u) {
                                     const Vec3d n = ownPoint(part, ownSample(part, {u, v})).normal;
                                     return glm::length(cofactor * n);
                                   },
                                   0, 1, 1e-8);
                             },
                             0, 1, 1e-7);
  return sum;
}

float MappedShape::area() const {
  if (uniformScale > 0) return static_cast<float>(ownArea * square(uniformScale));
  // The area is computed on demand: it is slow, and only the power of lights needs it.
  std::call_once(areaKnown, [this] { sceneArea = stretchedArea(); });
  return static_cast<float>(sceneArea);
}

ShapeSample MappedShape::sampleArea(float pick, const Vec2f& u) const {
  double chosen = double(pick) * ownArea;
  uint32_t part = 0;
  while (part + 1 < areas.size() && chosen >= areas[part]) chosen -= areas[part++];
  ShapeSample s;
  s.point = toScene(ownPoint(part, ownSample(part, Vec2d(u))));
  s.pdf = pdfArea(0, s.point);
  return s;
}

/** Points are uniform in own space, so that the area stretch of the map divides their density. */
float MappedShape::pdfArea(uint32_t, const SurfacePoint& point) const {
  const Vec3d normal = point.geometricNormal;
  return static_cast<float>(glm::length(glm::transpose(linear) * normal) / (ownArea * determinant));
}

FacePoint MappedShape::facePointOf(uint32_t, const SurfacePoint& point) const {
  const Vec3d own = inverse * (Vec3d(point.position) - center);
  FacePoint nearest;
  double least = std::numeric_limits<double>::infinity();
  for (uint32_t part = 0; part < areas.size(); ++part) {
    if (!(areas[part] > 0)) continue;
    const OwnPoint p = ownPoint(part, own);
    const double distance = glm::length(p.position - own);
    if (!(distance < least)) continue;
    least = distance;
    nearest = {part, p.uv};
  }
  return nearest;
}

class MappedShape::MappedSolid final : public Solid {
 public:
  explicit MappedSolid(const MappedShape& shape) : shape(shape) {}
  void crossings(const Vec3d& origin, const Vec3d& direction, std::vector<Crossing>& found) const override {
    static thread_local std::vector<LineHit> storage;
    LineHits hits(storage);
    shape.intersectAll(shape.toOwn(origin, direction), hits);
    for (const LineHit& m : hits)
      found.push_back({m.t, m.entering, 0, HitParameters(Vec3f(m.point), m.part)});
  }
  bool normalsPointIn() const override { return shape.side < 0; }

 private:
  const MappedShape& shape;
};

std::unique_ptr<Solid> MappedShape::asSolid() const {
  if (const std::string why = whyOpen(); !why.empty()) throw Error(why);
  return std::make_unique<MappedSolid>(*this);
}

void MappedShape::setSphericalCoordinates(OwnPoint& s) {
  const Vec3d& p = s.position;
  const double rho2 = p.x * p.x + p.y * p.y, rho = std::sqrt(rho2), r2 = rho2 + p.z * p.z;
  const double phi = std::atan2(p.y, p.x);
  s.uv = {(phi < 0 ? phi + TWO_PI : phi) / TWO_PI, std::atan2(rho, p.z) / PI_D};
  s.dpdu = s.dpdv = Vec3d(0);
  if (rho > 0) {
    const Vec3d du = Vec3d(-p.y, p.x, 0) / (rho2 * TWO_PI),
                dv = Vec3d(p.x * p.z / rho, p.y * p.z / rho, -rho) / (r2 * PI_D);
    const double determinant = glm::dot(s.normal, glm::cross(du, dv));
    if (std::abs(determinant) > 1e-6 * glm::length(du) * glm::length(dv)) {
      s.dpdu = glm::cross(dv, s.normal) / determinant;
      s.dpdv = glm::cross(s.normal, du) / determinant;
    }
  }
}

Bounds3d MappedShape::sectorBounds(double radius, double phiMax, double zLow, double zHigh) {
  const double x = radius * std::cos(phiMax), y = radius * std::sin(phiMax);
  const double half = 0.5 * TWO_PI;
  return {
      {phiMax >= half ? -radius : std::min(0.0, x), phiMax >= 1.5 * half ? -radius : std::min(0.0, y), zLow},
      {radius, phiMax >= 0.5 * half ? radius : y, zHigh}};
}

} // namespace recurse
