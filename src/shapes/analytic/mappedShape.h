/** @file
 * Shapes that are computed in double precision in their own space, of about unit size. An affine map takes
 * this space to the scene. A shape consists of parts (a side, its caps), numbered from 0.
 */
#pragma once

#include <mutex>
#include <vector>

#include "recurse/model/shape/shape.h"

namespace recurse {

class MappedShape : public Shape {
 public:
  uint32_t primitiveCount() const override { return 1; }
  Bounds3f bounds(uint32_t) const override { return box; }
  std::optional<PrimitiveHit> intersect(uint32_t, const Vec3f& origin, const Vec3f& direction, float tMin,
                                        float tMax) const override;
  SurfacePoint surfaceAt(uint32_t, const HitParameters& parameters) const override;
  float area() const override;
  ShapeSample sampleArea(float pick, const Vec2f& u) const override;
  float pdfArea(uint32_t, const SurfacePoint& point) const override;
  std::unique_ptr<Solid> asSolid() const override;
  uint32_t faceCount() const override {
    return pointOfPart(0, Vec2d(0.5)) ? static_cast<uint32_t>(areas.size()) : 0;
  }
  SurfacePoint pointOnFace(const FacePoint& p) const override {
    return toScene(ownPoint(p.face, *pointOfPart(p.face, p.uv)));
  }
  FacePoint facePointOf(uint32_t, const SurfacePoint& point) const override;

 protected:
  /** Line through own space. Hits outside [tMin, tMax] may be omitted, and with `nearestOnly` all hits
   * behind the first. */
  struct Line {
    Vec3d origin, direction;
    double tMin = -std::numeric_limits<double>::infinity(), tMax = std::numeric_limits<double>::infinity();
    bool nearestOnly = false;
    Vec3d at(double t) const { return origin + direction * t; }
  };
  /** Intersection of a line with the surface; `point` need not be accurate. */
  struct LineHit {
    double t = 0;
    uint32_t part = 0;
    bool entering = false; ///< valid for closed shapes only
    Vec3d point{0};
  };
  /** Hits of a line, sorted by t. */
  class LineHits {
   public:
    explicit LineHits(std::vector<LineHit>& storage) : list(storage) { list.clear(); }
    void add(const LineHit& m) {
      list.push_back(m);
      for (size_t i = list.size() - 1; i > 0 && list[i - 1].t > list[i].t; --i)
        std::swap(list[i - 1], list[i]);
    }
    bool empty() const { return list.empty(); }
    auto begin() const { return list.cbegin(); }
    auto end() const { return list.cend(); }

   private:
    std::vector<LineHit>& list;
  };
  /** Surface point in the shape's own space. */
  struct OwnPoint {
    Vec3d position;
    Vec3d normal; ///< unit, outwards
    Vec3d dpdu, dpdv;
    Vec3d dndu{0}, dndv{0};
    Vec2d uv;
    double error = 0; ///< bound on the distance from the surface
  };

  /** Must be called by constructors once the functions below work. `radius` is the radius of a cylinder
   * around the z axis that contains the shape; 0: unknown. */
  void prepare(const Mat4d& sceneFromOwn, const Bounds3d& ownBounds, std::vector<double> partAreas,
               bool reverseOrientation, double radius = 0);
  static constexpr double TWO_PI = 6.28318530717958647693;
  /** Bounding box of the sector within `radius` of the z axis, phi = 0 to phiMax [rad], zLow to zHigh. */
  static Bounds3d sectorBounds(double radius, double phiMax, double zLow, double zHigh);

  /** Sets uv, dpdu and dpdv of a point with position and normal: longitude and latitude around the origin,
   * and the derivatives along the surface. */
  static void setSphericalCoordinates(OwnPoint& s);

  virtual void intersectAll(const Line& line, LineHits& found) const = 0;
  /** Surface point of a part nearest to `near`, which is on the part up to rounding. */
  virtual OwnPoint ownPoint(uint32_t part, const Vec3d& near) const = 0;
  /** Maps the unit square to a part, uniform by area in own space. */
  virtual Vec3d ownSample(uint32_t part, const Vec2d& u) const = 0;
  /** Point of a part at (u, v); empty for shapes whose coordinates do not cover each point once. */
  virtual std::optional<Vec3d> pointOfPart(uint32_t /*part*/, const Vec2d& /*uv*/) const { return {}; }
  Vec3d inScene(const Vec3d& own) const { return center + linear * own; }
  /** Reason why the shape is no solid; empty where it is one. */
  virtual std::string whyOpen() const = 0;

 private:
  class MappedSolid;
  Line toOwn(const Vec3d& origin, const Vec3d& direction) const {
    Line line;
    line.origin = inverse * (origin - center);
    line.direction = inverse * direction;
    return line;
  }
  SurfacePoint toScene(const OwnPoint& own) const;
  double stretchedArea() const;

  Mat3d linear{1}, inverse{1}, magnitudes{1}; ///< to the scene, its inverse, absolute values of the former
  Vec3d center{0};
  Bounds3f box;
  Vec3d extent{0};           ///< extent of the shape in the scene
  double side = 1;           ///< -1 where the inside counts as outside
  double determinant = 1;    ///< absolute
  double uniformScale = 0;   ///< 0 where the map does not scale uniformly
  double roundingInOwn = 0;  ///< bound on the error of a point of the scene taken to the own space
  std::vector<double> areas; ///< areas of the parts in own space
  double ownArea = 0;
  mutable std::once_flag areaKnown;
  mutable double sceneArea = 0;
};

} // namespace recurse
