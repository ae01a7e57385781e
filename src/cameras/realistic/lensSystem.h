/** @file
 * Rays through a system of spherical lenses.
 *
 * The film is the plane z = 0 and the scene is towards +z. Lengths are in metres.
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
  double radius;    ///< radius of curvature; positive: convex towards the scene; 0: the plane of the stop
  double thickness; ///< distance to the next surface towards the film
  double index;     ///< refractive index behind the surface
  double apertureRadius;
  bool isStop() const { return radius == 0; }
};

struct LensRay {
  Vec3d origin, direction; ///< unit direction
  double weight = 1;       ///< transmittance of the aperture mask
};

class LensSystem {
 public:
  /** Thrown where no position of the film focuses at the requested distance. */
  struct CannotFocus : std::runtime_error {
    CannotFocus(const std::string& what, double nearest) : std::runtime_error(what), nearest(nearest) {}
    double nearest; ///< nearest distance from the film that can be in focus; 0: none
  };
  /** Transmittance at a point of the stop, in units of its radius; null: 1 everywhere. */
  using Mask = std::function<double(const Vec2d&)>;

  /** `surfaces` run from the scene to the film. The thickness behind the last one is set so that points at
   * the given distance from the film are in focus near the axis. Throws CannotFocus. */
  LensSystem(std::vector<LensSurface> surfaces, double focusDistance, Mask mask = {});

  /** Traces a ray from the film to where it leaves towards the scene; empty where it is blocked. */
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
