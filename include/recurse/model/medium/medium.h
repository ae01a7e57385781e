/** @file
 * Participating media: absorption, scattering and emission between surfaces.
 */
#pragma once

#include <memory>
#include <vector>

#include "recurse/core/math/ray.h"
#include "recurse/core/math/rgb.h"
#include "recurse/model/medium/phaseFunction.h"

namespace recurse {

/** Properties of a medium at a point. */
struct MediumPoint {
  Rgb absorption{0}, scattering{0}; ///< coefficients [1/length]
  Rgb emission{0};                  ///< emitted radiance per length [W/(m² sr) / scene unit]

  Rgb extinction() const { return absorption + scattering; }
};

/** Indices of the media on the two sides of a surface, whose geometric normal points outside; 0: vacuum. Both
 * are equal where the surface is no boundary. */
struct MediumInterface {
  uint16_t inside = 0, outside = 0;
  bool isBoundary() const { return inside != outside; }
};

/** Upper bounds of a field in the unit cube, one for each cell of a grid, x fastest. */
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

/** Interval of a ray with a majorant: a bound of the extinction that holds everywhere in it. */
struct MajorantSegment {
  float begin = 0, end = 0; ///< distances from the origin of the ray [scene units]
  Rgb majorant{0};          ///< [1/length]
};

/** Majorant segments of a ray in order: one in a homogeneous medium, else one for each non-empty cell. */
class MajorantSegments {
 public:
  /** The interval [0, end) with one majorant. */
  MajorantSegments(float end, const Rgb& majorant) : whole{0, end, majorant}, one(true) {}
  /** Cells of a grid along a ray in unit-cube coordinates, up to `end`. Majorants are `extinction` times the
   * grid's bounds. The direction is not of unit length: distances are along the scene's ray. The grid must
   * outlive the segments. */
  MajorantSegments(const MajorantGrid& grid, const Rgb& extinction, const Vec3f& origin,
                   const Vec3f& direction, float end);

  bool next(MajorantSegment& segment); ///< sets the next segment; false at the end

 private:
  MajorantSegment whole;
  bool one = false;
  const MajorantGrid* grid = nullptr;
  float t = 0, end = 0;
  glm::ivec3 cell{0}, step{0};
  Vec3f nextT{0}, deltaT{0};
};

/** Medium of a scene. Immutable; any thread may call it. */
class Medium {
 public:
  virtual ~Medium() = default;
  /** Properties at a position in the scene. */
  virtual MediumPoint at(const Vec3f& position) const = 0;
  /** Majorants along a ray of unit direction, from its origin to the distance `end` [scene units], which may
   * be infinite. The medium is absent where there is no segment, and must outlive the result. */
  virtual MajorantSegments segments(const Ray& ray, float end) const = 0;
  /** True where the medium is constant: transmittance is analytic, and the majorant is the extinction. */
  virtual bool isHomogeneous() const { return false; }
  virtual bool isEmissive() const { return false; }
  /** Box outside of which the medium is absent; infinite where no such box is known. */
  virtual Bounds3f bounds() const { return {Vec3f(-INFINITE), Vec3f(INFINITE)}; }

  std::unique_ptr<const PhaseFunction> phase; ///< never null in a scene
};

/** Arguments of makers of media besides parameters. */
struct MediumContext {
  Mat4d sceneFromMedium{1};
  /** Above it the mean free path vanishes in the rounding of positions [1/length]. Homogeneous media are
   * scaled down to it, at constant albedo. */
  float maxExtinction = INFINITE;
};

} // namespace recurse
