/** @file
 * Functions that shapes share: sampling of solid angle by area, boxes and error bounds.
 */
#include "recurse/model/shape/shape.h"

#include "recurse/core/threads/inPlace.h"

namespace recurse {

namespace {

/** Converts a density per area to a density per solid angle, as seen from `from`. Returns 0 where the surface
 * is seen edge-on. */
float solidAngleDensity(float areaDensity, const Vec3f& from, const SurfacePoint& point) {
  const Vec3d way = Vec3d(point.position) - Vec3d(from);
  const double distance2 = glm::dot(way, way);
  const double across = std::abs(glm::dot(Vec3d(point.geometricNormal), way)); // distance times cosine
  if (!(across > 0)) return 0;
  // The division does not depend on the square root, so that they overlap.
  const auto density = static_cast<float>(double(areaDensity) * distance2 / across * std::sqrt(distance2));
  return std::isfinite(density) ? density : 0;
}

} // namespace

std::optional<ShapeSample> Shape::sampleDirection(const Vec3f& from, float pick, const Vec2f& u) const {
  std::optional<ShapeSample> s;
  const auto sample = [&] { return sampleArea(pick, u); };
  s.emplace(Made(sample));
  if (s->pdf > 0) s->pdf = solidAngleDensity(s->pdf, from, s->point);
  if (!(s->pdf > 0)) s.reset();
  return s;
}

float Shape::pdfDirection(const Vec3f& from, uint32_t primitive, const SurfacePoint& point) const {
  return solidAngleDensity(pdfArea(primitive, point), from, point);
}

std::vector<RimPiece> rimOfSweep(const std::function<Vec3d(double, double)>& p, bool uEnds, bool vLow,
                                 bool vHigh) {
  constexpr int PIECES = 16;
  constexpr double HALF_LENGTH = 0.0002,
                   INWARDS = 0.002; // lengths in the unit square, over which curvature is far below 1 %
  std::vector<RimPiece> rim;
  const auto addEdge = [&](const auto& along, double end) {
    const double inner = end > 0.5 ? end - INWARDS : end + INWARDS;
    for (int i = 0; i < PIECES; ++i) {
      const double s = (i + 0.5) / PIECES;
      const RimPiece piece{Vec3f(along(s - HALF_LENGTH, end)), Vec3f(along(s + HALF_LENGTH, end)),
                           Vec3f(along(s, inner))};
      if (piece.from != piece.to) rim.push_back(piece);
    }
  };
  if (vLow) addEdge(p, 0);
  if (vHigh) addEdge(p, 1);
  if (!uEnds) return rim;
  const auto turned = [&](double v, double u) { return p(u, v); };
  addEdge(turned, 0);
  addEdge(turned, 1);
  return rim;
}

std::unique_ptr<Solid> Shape::asSolid() const { throw Error("it is not a closed surface"); }

Bounds3f Shape::bounds() const {
  Bounds3f all;
  for (uint32_t i = 0; i < primitiveCount(); ++i) all.add(bounds(i));
  return all;
}

Bounds3f roundedOut(const Bounds3d& box) {
  // The corners carry the rounding error of a few operations in double precision.
  const double slack = 0x1p-48 * glm::length(glm::max(glm::abs(box.lower), glm::abs(box.upper)));
  Bounds3f out;
  for (int i = 0; i < 3; ++i) {
    out.lower[i] = std::nextafter(static_cast<float>(box.lower[i] - slack), -INFINITE);
    out.upper[i] = std::nextafter(static_cast<float>(box.upper[i] + slack), INFINITE);
  }
  return out;
}

void transformDirections(const Mat3d& map, const Mat3d& normalMap, SurfacePoint& p) {
  const Vec3d normal = normalMap * Vec3d(p.shadingNormal);
  p.dndu = derivativeOfUnit(normal, normalMap * Vec3d(p.dndu), 1);
  p.dndv = derivativeOfUnit(normal, normalMap * Vec3d(p.dndv), 1);
  p.geometricNormal = Vec3f(glm::normalize(normalMap * Vec3d(p.geometricNormal)));
  p.shadingNormal = Vec3f(glm::normalize(normal));
  p.dpdu = Vec3f(map * Vec3d(p.dpdu));
  p.dpdv = Vec3f(map * Vec3d(p.dpdv));
  if (p.crossTangent != 0 && glm::determinant(map) < 0) p.crossTangent = static_cast<int8_t>(-p.crossTangent);
}

} // namespace recurse
