/** @file
 * The opening of a thin lens: a disc, or a regular polygon of blades.
 */
#pragma once

#include "recurse/core/sampling/sampling.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Parameters of cameras with a thin lens. */
inline std::vector<ParameterSpec> apertureParameters() {
  return {
      realParameter("lensradius", "0",
                    "radius of the lens [scene units]; 0: a pinhole, everything is in focus")
          .range(0, 1e30),
      realParameter("focaldistance", "1000000", "distance of the plane in focus, along the axis").positive(),
      integerParameter(
          "apertureblades", "0",
          "number of sides of the aperture, a regular polygon in the circle of the lens; 0: round")
          .range(0, 64),
      realParameter("aperturerotation", "0",
                    "rotation of the polygon [degrees]; at 0 a corner points to the right")};
}

struct Aperture {
  double radius = 0;
  double focalDistance = 1e6;
  int blades = 0;      ///< 0: round
  double rotation = 0; ///< [radians]

  explicit Aperture(const Parameters& p)
      : radius(p.real("lensradius")), focalDistance(p.real("focaldistance")),
        blades(p.integer("apertureblades")), rotation(glm::radians(p.real("aperturerotation"))) {
    if (blades == 1 || blades == 2)
      p.fail("apertureblades", "a polygon has at least three sides", "0 or 3 to 64");
  }

  /** Point on the lens, uniform by area. */
  Vec2d sample(const Vec2f& u) const {
    if (blades == 0) return Vec2d(uniformDisk(u)) * radius;
    // Chooses a triangle around the middle, then a uniform point in it, whose distance is the root of u.y.
    const double along = double(u.x) * blades;
    const double side = std::floor(along), across = along - side, out = std::sqrt(double(u.y));
    return glm::mix(corner(side), corner(side + 1), across) * (radius * out);
  }
  double area() const {
    return blades == 0 ? M_PI * square(radius) : blades * 0.5 * square(radius) * std::sin(2 * M_PI / blades);
  }

 private:
  Vec2d corner(double i) const {
    const double angle = rotation + 2 * M_PI * i / blades;
    return {std::cos(angle), std::sin(angle)};
  }
};

} // namespace recurse
