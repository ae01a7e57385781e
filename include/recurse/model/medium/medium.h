/** @file
 * Participating media: what absorbs, scatters and emits light between surfaces.
 */
#pragma once

#include <memory>
#include <vector>

#include "recurse/core/math/ray.h"
#include "recurse/core/math/rgb.h"
#include "recurse/model/medium/phaseFunction.h"

namespace recurse {

/** A medium at a point. */
struct MediumPoint {
  Rgb absorption{0}, scattering{0}; ///< coefficients [1/length]
  Rgb emission{0};                  ///< radiance that a unit of length adds

  Rgb extinction() const { return absorption + scattering; }
};

/** The numbers of the media on the two sides of a surface, the geometric normal pointing outside; 0: vacuum.
 */
struct MediumInterface {
  uint16_t inside = 0, outside = 0;
  bool isBoundary() const { return inside != outside; }
};

/** Upper bounds of a field in the unit cube, by cells. */
class MajorantGrid {
 public:
  MajorantGrid() = default;
  MajorantGrid(const glm::ivec3& resolution, std::vector<float> bounds)
      : resolution(resolution), bounds(std::move(bounds)) {}

  const glm::ivec3& size() const { return resolution; }
  float at(const glm::ivec3& cell) const {
    return bounds[(size_t(cell.z) * size_t(resolution.y) + size_t(cell.y)) * size_t(resolution.x) +
                  size_t(cell.x)];
  }

 private:
  glm::ivec3 resolution{0};
  std::vector<float> bounds;
};

/** A part of a ray with a bound of the extinction that holds everywhere in it. */
struct MajorantSegment {
  float begin = 0, end = 0;
  Rgb majorant{0}; ///< [1/length]
};

/** The segments of a ray in a medium, in order: one in a homogeneous medium, the cells on its way else. */
class MajorantSegments {
 public:
  /** The ray's first `end` with the same bound everywhere. */
  MajorantSegments(float end, const Rgb& majorant) : whole{0, end, majorant}, one(true) {}
  /** The cells of a grid, a ray in the unit cube's coordinates meets before `end`; bounds are `extinction`
   * times those of the grid. The direction is not of unit length: distances are those of the scene's ray. */
  MajorantSegments(const MajorantGrid& grid, const Rgb& extinction, const Vec3f& origin,
                   const Vec3f& direction, float end);

  bool next(MajorantSegment& segment);

 private:
  MajorantSegment whole;
  bool one = false;
  const MajorantGrid* grid = nullptr;
  float t = 0, end = 0;
  glm::ivec3 cell{0}, step{0};
  Vec3f nextT{0}, deltaT{0};
};

class Medium {
 public:
  virtual ~Medium() = default;
  virtual MediumPoint at(const Vec3f& position) const = 0;
  /** Bounds of the extinction along a ray of unit direction, as far as `end`. Where there is none, there is
   * no medium. */
  virtual MajorantSegments segments(const Ray& ray, float end) const = 0;
  /** The same everywhere, so that transmittance has a closed form: the bound is the extinction. */
  virtual bool isHomogeneous() const { return false; }
  virtual bool isEmissive() const { return false; }
  /** There is nothing of the medium outside; infinite where that is known of no box. */
  virtual Bounds3f bounds() const { return {Vec3f(-INFINITE), Vec3f(INFINITE)}; }

  std::unique_ptr<const PhaseFunction> phase; ///< never null in a scene
};

/** What makers of media are given besides parameters. */
struct MediumContext {
  Mat4d sceneFromMedium{1};
  /** Beyond it the mean free path is lost in the rounding of positions [1/length]. */
  float maxExtinction = INFINITE;
};

} // namespace recurse
