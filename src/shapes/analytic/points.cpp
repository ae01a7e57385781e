/** @file
 * Point clouds: many spheres or discs as primitives of one shape, so that Embree's tree separates them.
 * Computed in double precision; a point takes 16 bytes, or 28 with its normal.
 */
#include <mutex>

#include "recurse/core/math/integrate.h"
#include "recurse/core/sampling/sampling.h"
#include "recurse/core/threads/resources.h"
#include "recurse/model/mesh/plyFile.h"
#include "recurse/model/scene/plugIns.h"
#include "shapes/analytic/ellipsoid.h"

namespace recurse {

namespace {

/** Base of spheres and discs around points: the points, and sampling by the squares of their radii. */
class PointCloud : public Shape {
 public:
  PointCloud(const PlyPoints& points, const ShapeContext& context)
      : map(Mat3d(context.sceneFromObject), context.reverseOrientation) {
    spots.reserve(points.positions.size());
    for (size_t i = 0; i < points.positions.size(); ++i) {
      spots.push_back({Vec3f(transformPoint(context.sceneFromObject, points.positions[i])),
                       static_cast<float>(points.radii[i])});
      if (!isFinite(spots.back().center) || !std::isfinite(spots.back().radius))
        throw Error("point " + std::to_string(i) + " is too large for single precision");
      if (!(spots.back().radius > 0))
        throw Error("the radius of point " + std::to_string(i) + " is too small for single precision");
    }
  }

  uint32_t primitiveCount() const override { return static_cast<uint32_t>(spots.size()); }
  /** Boxes around the centre of a point, over some of them. */
  double testsOfRay() const override {
    const double count = double(spots.size());
    const auto probes = static_cast<size_t>(std::clamp(1e7 / count, 1.0, std::min(count, 64.0)));
    double found = 0;
    for (size_t k = 0; k < probes; ++k)
      for (uint32_t i = 0; i < primitiveCount(); ++i)
        found += bounds(i).contains(spots[k * spots.size() / probes].center);
    return found / double(probes);
  }
  uint32_t faceCount() const override { return primitiveCount(); }
  FacePoint facePointOf(uint32_t primitive, const SurfacePoint& point) const override {
    return {primitive, Vec2d(point.uv)};
  }

 protected:
  struct Spot {
    Vec3f center;
    float radius; ///< before the map
  };

  /** Primitive chosen with a probability in proportion to its squared radius. */
  uint32_t chosen(float pick) const {
    sumSquares();
    const double wanted = double(pick) * sums.back();
    const auto i = static_cast<size_t>(std::upper_bound(sums.begin(), sums.end() - 1, wanted) - sums.begin());
    return static_cast<uint32_t>(i);
  }
  double sumOfSquares() const {
    sumSquares();
    return sums.back();
  }

  EllipsoidMap map;
  std::vector<Spot> spots;

 private:
  /** The table is made at first use, since only lights are sampled. */
  void sumSquares() const {
    std::call_once(summed, [this] {
      double sum = 0;
      sums.reserve(spots.size());
      for (const Spot& s : spots) sums.push_back(sum += square(double(s.radius)));
    });
  }
  mutable std::once_flag summed;
  mutable std::vector<double> sums; ///< squared radii of points [0, i]
};

class PointSpheres final : public PointCloud {
 public:
  using PointCloud::PointCloud;

  Bounds3f bounds(uint32_t i) const override {
    const Vec3d center = spots[i].center, extent = map.extent() * double(spots[i].radius);
    return roundedOut(Bounds3d{center - extent, center + extent});
  }

  std::optional<PrimitiveHit> intersect(uint32_t i, const Vec3f& origin, const Vec3f& direction, float tMin,
                                        float tMax) const override {
    const double scale = 1 / double(spots[i].radius);
    const Vec3d o = map.inverse * (Vec3d(origin) - Vec3d(spots[i].center)) * scale,
                d = map.inverse * Vec3d(direction) * scale;
    double ts[2];
    if (!intersectUnitSphere(o, d, ts)) return {};
    for (const double t : ts) {
      const auto rounded = static_cast<float>(t);
      if (rounded > tMin && rounded < tMax)
        return PrimitiveHit{rounded, HitParameters(Vec3f(glm::normalize(o + d * t)))};
    }
    return {};
  }

  /** Hit parameters are the point on the unit sphere. */
  SurfacePoint surfaceAt(uint32_t i, const HitParameters& parameters) const override {
    return pointAt(i, glm::normalize(Vec3d(parameters.point())));
  }
  SurfacePoint placeAt(uint32_t i, const HitParameters& parameters) const override {
    return map.placeAt(spots[i].center, double(spots[i].radius), glm::normalize(Vec3d(parameters.point())));
  }
  SurfacePoint pointOnFace(const FacePoint& p) const override {
    return pointAt(p.face, SphereAngles().pointAt(p.uv.x, p.uv.y));
  }

  float area() const override {
    std::call_once(areaKnown, [this] { unitArea = stretchedArea(); });
    return static_cast<float>(unitArea * sumOfSquares());
  }
  ShapeSample sampleArea(float pick, const Vec2f& u) const override {
    ShapeSample s;
    s.primitive = chosen(pick);
    s.point = pointAt(s.primitive, glm::normalize(Vec3d(uniformSphere(u))));
    s.pdf = pdfArea(s.primitive, s.point);
    return s;
  }
  /** Points are uniform on the unit sphere, so that the area stretch of the map divides their density. */
  float pdfArea(uint32_t, const SurfacePoint& point) const override {
    return static_cast<float>(1 / (4 * PI_D * sumOfSquares() * map.stretch(point.geometricNormal)));
  }

 private:
  SurfacePoint pointAt(uint32_t i, const Vec3d& unit) const {
    return map.pointAt(spots[i].center, double(spots[i].radius), unit, {});
  }

  /** Area of the image of the unit sphere. */
  double stretchedArea() const {
    if (map.uniformScale > 0) return 4 * PI_D * square(map.uniformScale);
    const Mat3d cofactor = glm::transpose(map.inverse) * map.determinant;
    const auto aroundAt = [&](double z) {
      const double r = std::sqrt(std::max(0.0, 1 - z * z));
      return integrate(
          [&](double phi) { return glm::length(cofactor * Vec3d(r * std::cos(phi), r * std::sin(phi), z)); },
          0, 2 * PI_D, 1e-8);
    };
    return integrate(aroundAt, -1, 1, 1e-7);
  }

  mutable std::once_flag areaKnown;
  mutable double unitArea = 0;
};

class PointDiscs final : public PointCloud {
 public:
  PointDiscs(const PlyPoints& points, const ShapeContext& context) : PointCloud(points, context) {
    normals.reserve(points.normals.size());
    for (const Vec3d& n : points.normals) normals.emplace_back(glm::normalize(n));
  }

  Bounds3f bounds(uint32_t i) const override {
    const Disc d = disc(i);
    const Vec3d extent = glm::sqrt(d.axisX * d.axisX + d.axisY * d.axisY), center = spots[i].center;
    return roundedOut(Bounds3d{center - extent, center + extent});
  }

  std::optional<PrimitiveHit> intersect(uint32_t i, const Vec3f& origin, const Vec3f& direction, float tMin,
                                        float tMax) const override {
    const Disc disc = this->disc(i);
    const Vec3d o = Vec3d(origin) - Vec3d(spots[i].center), d = direction;
    const double slope = glm::dot(disc.normal, d);
    if (slope == 0) return {};
    const double t = -glm::dot(disc.normal, o) / slope;
    const auto rounded = static_cast<float>(t);
    if (!(rounded > tMin && rounded < tMax)) return {};
    const Vec3d p = map.inverse * (o + d * t) / double(spots[i].radius);
    const Vec2d onDisc(glm::dot(p, disc.ownX), glm::dot(p, disc.ownY));
    if (glm::dot(onDisc, onDisc) > 1) return {};
    return PrimitiveHit{rounded, HitParameters(Vec2f(onDisc))};
  }

  /** Hit parameters are coordinates on the unit disc. */
  SurfacePoint surfaceAt(uint32_t i, const HitParameters& parameters) const override {
    Vec2d p(parameters.uv);
    const double r = glm::length(p);
    if (r > 1) p /= r; // outside by rounding
    const Disc d = disc(i);
    const Vec3d center = spots[i].center, position = center + d.axisX * p.x + d.axisY * p.y;
    SurfacePoint s;
    s.position = Vec3f(position);
    s.geometricNormal = s.shadingNormal = Vec3f(d.normal * map.side);
    const Vec3d extent = 2.0 * glm::sqrt(d.axisX * d.axisX + d.axisY * d.axisY);
    s.error = positionError(position, 0x1p-50 * (glm::abs(d.axisX) + glm::abs(d.axisY) + glm::abs(center)),
                            d.normal, flatOffset(extent, position, d.normal));
    s.dpdu = Vec3f(2.0 * d.axisX);
    s.dpdv = Vec3f(2.0 * d.axisY);
    s.uv = Vec2f(0.5 + 0.5 * p);
    return s;
  }
  /** The square is mapped to the disc with equal areas; its corners have no other coordinates. */
  SurfacePoint pointOnFace(const FacePoint& p) const override {
    return surfaceAt(p.face, HitParameters(uniformDisk(Vec2f(p.uv))));
  }
  FacePoint facePointOf(uint32_t primitive, const SurfacePoint& point) const override {
    return {primitive, Vec2d(squareOfDisk(point.uv * 2.0f - 1.0f))};
  }

  float area() const override {
    std::call_once(areaKnown, [this] {
      for (uint32_t i = 0; i < primitiveCount(); ++i) totalArea += areaOf(i);
    });
    return static_cast<float>(totalArea);
  }
  ShapeSample sampleArea(float pick, const Vec2f& u) const override {
    ShapeSample s;
    s.primitive = chosen(pick);
    s.point = surfaceAt(s.primitive, HitParameters(uniformDisk(u)));
    s.pdf = pdfArea(s.primitive, s.point);
    return s;
  }
  float pdfArea(uint32_t i, const SurfacePoint&) const override {
    return static_cast<float>(square(double(spots[i].radius)) / (sumOfSquares() * areaOf(i)));
  }
  /** A piece of zero length, that is, a rim without location: discs enclose no volume. */
  std::vector<RimPiece> rim() const override {
    const Vec3f start = spots.front().center;
    return {{start, start, start}};
  }

 private:
  struct Disc {
    Vec3d ownX, ownY;   ///< axes of the unit disc before the map
    Vec3d axisX, axisY; ///< axes in the scene
    Vec3d normal;       ///< unit, in the scene, on the side of the point's normal
  };
  Disc disc(uint32_t i) const {
    const Vec3d n = glm::normalize(Vec3d(normals[i]));
    const Vec3d unlike = std::abs(n.x) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
    Disc d;
    d.ownX = glm::normalize(glm::cross(n, unlike));
    d.ownY = glm::cross(n, d.ownX);
    d.axisX = map.linear * d.ownX * double(spots[i].radius);
    d.axisY = map.linear * d.ownY * double(spots[i].radius);
    d.normal = glm::normalize(glm::transpose(map.inverse) * n);
    return d;
  }
  double areaOf(uint32_t i) const {
    const Disc d = disc(i);
    return PI_D * glm::length(glm::cross(d.axisX, d.axisY));
  }

  std::vector<Vec3f> normals; ///< unit, before the map
  mutable std::once_flag areaKnown;
  mutable double totalArea = 0;
};

/** Radii as the parameter gives them, one for all or one each; false where it does not. */
bool readRadii(const Parameters& p, PlyPoints& points) {
  if (!p.has("radius")) return !points.radii.empty();
  points.radii = p.reals("radius");
  const size_t count = points.positions.size();
  if (points.radii.size() == 1) points.radii.assign(count, points.radii[0]);
  if (points.radii.size() != count)
    p.fail("radius", std::to_string(points.radii.size()) + " given for " + std::to_string(count) + " points",
           "one for all, or one for each");
  return true;
}

PlyPoints readPointFile(const Parameters& p) {
  for (const char* name : {"P", "N"})
    if (p.has(name)) p.fail(name, "the points are in the file", "\"filename\", or \"P\" and \"N\"");
  try {
    return readPlyPoints(p.file("filename"));
  } catch (const SceneError&) {
    throw;
  } catch (const Error& e) {
    p.fail("filename", e.what());
  }
}

PlyPoints readPoints(const Parameters& p) {
  PlyPoints points;
  if (p.has("filename")) {
    points = readPointFile(p);
  } else {
    if (!p.has("P")) p.fail("", "there are no points", "\"point3 P\", or \"filename\" of a PLY file");
    points.positions = p.vector3s("P");
    if (p.has("N")) points.normals = p.vector3s("N");
  }
  const char* const source = p.has("filename") ? "filename" : "P";
  if (!readRadii(p, points))
    p.fail(source, "the points have no radius", "\"float radius\", one for all or one each");
  for (size_t i = 0; i < points.radii.size(); ++i)
    if (!(points.radii[i] > 0))
      p.fail(source, "point " + std::to_string(i) + " has a radius that is not positive");
  return points;
}

void checkNormals(const Parameters& p, const PlyPoints& points) {
  const char* const source = p.has("N") ? "N" : p.has("filename") ? "filename" : "type";
  if (points.normals.size() != points.positions.size())
    p.fail(source,
           std::to_string(points.normals.size()) +
               (points.normals.size() == 1 ? " normal given for " : " normals given for ") +
               std::to_string(points.positions.size()) + (points.positions.size() == 1 ? " disc" : " discs"),
           "\"normal N\", or nx ny nz in the file, one for each point");
  for (size_t i = 0; i < points.normals.size(); ++i)
    if (!(glm::length(points.normals[i]) > 0) || !std::isfinite(glm::length(points.normals[i])))
      p.fail(source, "the normal of point " + std::to_string(i) + " is zero or not finite");
}

std::unique_ptr<Shape> makePoints(const Parameters& p, const ShapeContext& context) {
  const PlyPoints points = readPoints(p);
  constexpr double POINT_BYTES = 28 + 150; // the point, and its share of Embree's tree
  requireMemory("a cloud of points", POINT_BYTES * double(points.positions.size()));
  const char* const source = p.has("filename") ? "filename" : "P";
  const std::string word = p.string("type");
  const bool hasDiscs = word == "disk" || (word == "auto" && !points.normals.empty());
  if (hasDiscs) checkNormals(p, points);
  if (!hasDiscs && p.has("N")) p.warn("N", "spheres do not use normals");
  try {
    if (hasDiscs) return std::make_unique<PointDiscs>(points, context);
    return std::make_unique<PointSpheres>(points, context);
  } catch (const Error& e) {
    p.fail(source, e.what());
  }
}

} // namespace

void registerPoints(PlugIns& plugIns) {
  plugIns.shapes.add(
      {{.name = "points",
        .summary = "A cloud of points, each a sphere or a disc.",
        .parameters =
            {stringParameter("filename", "",
                             "PLY file, text or binary, also compressed with gzip; its vertices need x y z, "
                             "and may have radius and nx ny nz"),
             arrayParameter(ParameterType::POINT3, "P", 0, "", "positions, without a file"),
             arrayParameter(ParameterType::NORMAL, "N", 0, "", "normals of discs, one for each of P"),
             arrayParameter(ParameterType::REAL, "radius", 0, "",
                            "radius, one for all or one each; by default from the file")
                 .positive(),
             stringParameter("type", "auto",
                             "\"sphere\", \"disk\" (perpendicular to its normal), or \"auto\": discs where "
                             "there are normals")
                 .oneOf({"auto", "sphere", "disk"})},
        .examples = {"\"point3 P\" [0 0 0  2.2 .2 .1  .3 2.5 .4] \"float radius\" [1 .8 .6]",
                     "\"point3 P\" [0 0 0  2.2 .2 .1  .3 2.5 .4] \"float radius\" .9 "
                     "\"normal N\" [0 0 2  .6 0 .8  1 -1 1]"}},
       makePoints});
}

} // namespace recurse
