/** @file
 * Thin curves: cubic Bézier segments of varying width, which Embree intersects.
 */
#pragma once

#include "recurse/model/shape/shape.h"

namespace recurse {

class CurveShape final : public Shape {
 public:
  /** FLAT: faces the ray; CYLINDER: likewise, with normals that vary across the width; RIBBON: oriented by
   * its normals, which determine its apparent width. */
  enum class Kind { FLAT, CYLINDER, RIBBON };
  /** Bézier segment in the object's space. */
  struct Segment {
    Vec3d controls[4];
    double width0, width1;        ///< diameters [object units], linear in between; scaled by cbrt(|det|)
    Vec3d normal0{0}, normal1{0}; ///< at the ends, for ribbons; of any length but zero
  };

  /** Throws Error for a position too large for single precision. */
  CurveShape(const std::vector<Segment>& segments, Kind kind, const ShapeContext& context);

  Kind kind() const { return curveKind; }
  /** Control points with radius [scene units] in w, four for each segment. */
  const std::vector<glm::vec4>& controls() const { return points; }
  /** Parameters for surfaceAt() of Embree's hit at u on a segment: u, v in [-1, 1] across the width, and the
   * flat curve's unit normal. The ray's direction may have any length. Empty where a ribbon seen at an angle
   * is narrower than the hit. */
  std::optional<HitParameters> parametersOf(uint32_t segment, float u, const Vec3f& origin,
                                            const Vec3f& direction, float t) const;

  uint32_t primitiveCount() const override { return static_cast<uint32_t>(points.size() / 4); }
  Bounds3f bounds(uint32_t segment) const override;
  /** Throws std::logic_error: Embree intersects curves. */
  std::optional<PrimitiveHit> intersect(uint32_t, const Vec3f&, const Vec3f&, float, float) const override;
  SurfacePoint surfaceAt(uint32_t segment, const HitParameters& parameters) const override;
  /** A piece of zero length, that is, a rim without location: curves enclose no volume. */
  std::vector<RimPiece> rim() const override {
    const Vec3f start(points.front());
    return {{start, start, start}};
  }
  bool canBeSampled() const override { return false; }
  float area() const override { return 0; }
  ShapeSample sampleArea(float, const Vec2f&) const override { return {}; }

 private:
  struct Place {
    Vec3d position, tangent; ///< the tangent is the derivative by u
    double radius;
  };
  Place placeOn(uint32_t segment, double u) const;

  Kind curveKind;
  std::vector<glm::vec4> points;
  std::vector<Vec3d> ends; ///< for ribbons: unit normals at both ends of each segment
  float side = 1;          ///< -1: reversed orientation
};

} // namespace recurse
