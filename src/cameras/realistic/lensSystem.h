/** @file
 * Rays through a system of spherical lenses.
 *
 * The film lies in the plane z = 0 and the scene is towards +z. Lengths are in metres.
 */
#pragma once

#include <functional>
#include <optional>
#include <stdexcept>
#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

/** A surface of a lens, or the aperture stop. */
struct LensSurface {
  double radius;    ///< of curvature; positive: it bulges towards the scene; 0: a plane
  double thickness; ///< distance to the next surface towards the film
  double index;     ///< of refraction, behind the surface
  double apertureRadius;
  bool isStop() const { return radius == 0; }
};

struct LensRay {
  Vec3d origin, direction; ///< unit direction
  double weight = 1;       ///< what the aperture lets through
};

class LensSystem {
 public:
  /** No place of the film is in focus at the distance. */
  struct CannotFocus : std::runtime_error {
    CannotFocus(const std::string& what, double nearest) : std::runtime_error(what), nearest(nearest) {}
    double nearest; ///< distance from the film that can be; 0: none
  };
  /** What part of the light passes at a place of the stop, in units of its radius; null: all. */
  using Mask = std::function<double(const Vec2d&)>;

  /** `surfaces` from the scene to the film; the thickness behind the last one is found so that what lies in
   * the given distance from the film is in focus near the axis. */
  LensSystem(std::vector<LensSurface> surfaces, double focusDistance, Mask mask = {});

  /** A ray from the film as it leaves towards the scene; none where something stops it. */
  std::optional<LensRay> trace(const LensRay& fromFilm) const;
  double focalLength() const { return focal; }
  double rearZ() const { return list.back().thickness; }
  double rearRadius() const { return list.back().apertureRadius; }

 private:
  std::vector<LensSurface> list;
  Mask mask;
  double focal = 0;
};

} // namespace recurse
