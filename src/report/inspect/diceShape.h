/** @file
 * Triangles of shapes that have no faces: by rays through a grid, and tubes of curves.
 */
#pragma once

#include <array>
#include <vector>

#include "recurse/model/shape/curveShape.h"

namespace recurse {

/** Triangle in the shape's space, with a surface point for its colour. */
struct DicedTriangle {
  std::array<Vec3f, 3> corners;
  uint32_t primitive = 0;
  HitParameters parameters; ///< of a point of the surface near the triangle
};

/**
 * Surface of any shape that rays can intersect, open or closed, by dual contouring of a grid of cubes with
 * `cells` along the longest side of its box (Ju et al., "Dual Contouring of Hermite Data", 2002). Rays along
 * the grid's edges find the surface; each edge that crosses it joins the vertices of its four cubes. Details
 * smaller than a cube may be missing.
 */
std::vector<DicedTriangle> dicedByRays(const Shape& shape, int cells);

/** Pieces along each segment of a curve, and sides of its tube; one side is a flat ribbon. */
struct CurveDicing {
  uint32_t pieces = 8, sides = 4;
  uint32_t triangles() const { return 2 * pieces * sides; } ///< for each segment
};

/** Tube of a segment, with its widths multiplied by `widening`. */
std::vector<DicedTriangle> dicedCurve(const CurveShape& curve, uint32_t segment, const CurveDicing& dicing,
                                      float widening);

} // namespace recurse
