/** @file
 * Scenes for tests of path guiding.
 */
#pragma once

#include "sceneRendering.h"

namespace recurse::testing {

/** A room lit through a slit in the wall to a second room with a lamp. */
inline std::string slitRoom() {
  return view(32, 24, "-1.8 0 0  1 0 0  0 1 0", perspective(70)) + R"(
Material "diffuse" "rgb reflectance" [ .6 .6 .6 ]
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point3 P" [ -2 -1 -1  4 -1 -1  4 -1 1  -2 -1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point3 P" [ -2 1 -1  4 1 -1  4 1 1  -2 1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point3 P" [ -2 -1 -1  4 -1 -1  4 1 -1  -2 1 -1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point3 P" [ -2 -1 1  4 -1 1  4 1 1  -2 1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point3 P" [ -2 -1 -1  -2 1 -1  -2 1 1  -2 -1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point3 P" [ 4 -1 -1  4 1 -1  4 1 1  4 -1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2 0 2 3 ] "point3 P" [ 1 -1 -1  1 1 -1  1 1 .8  1 -1 .8 ]
AreaLightSource "diffuse" "rgb L" [ 20 20 20 ]
Translate 2.5 .5 -.7
Shape "sphere" "float radius" .2
)";
}

/** A floor of albedo .5 below a black ceiling at height 1, with a square hole of half width `hole`; 0: no
 * ceiling. Above it is a screen of radiance HOLE_RADIANCE, lit from behind. The camera looks at the middle of
 * the floor. Only the first vertex on the floor has two kinds of directions; everything beyond it is free of
 * noise. The film is so small that the floor is one cell of the guide. */
inline std::string floorBelowHole(double hole, int resolution = 2) {
  const auto slab = [](double x0, double x1, double z0, double z1, double y) {
    const auto corner = [&](double x, double z) {
      return number(x) + " " + number(y) + " " + number(z) + "  ";
    };
    return "Shape \"bilinearmesh\" \"point3 P\" [ " + corner(x0, z0) + corner(x1, z0) + corner(x0, z1) +
           corner(x1, z1) + "]\n";
  };
  std::string out =
      view(resolution, resolution, "0 .5 -3  0 0 0  0 1 0", perspective(.1)) +
      "LightSource \"distant\" \"rgb L\" [ 10 10 10 ] \"point3 from\" [ 0 1 0 ] \"point3 to\" [ 0 0 0 ]\n" +
      "Material \"diffusetransmission\" \"float reflectance\" 0 \"float transmittance\" .8\n" +
      slab(-40, 40, -40, 40, 3) + "Material \"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]\n" +
      slab(-4, 4, -4, 4, 0);
  if (hole > 0)
    out += "Material \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]\n" + slab(-40, -hole, -40, 40, 1) +
           slab(hole, 40, -40, 40, 1) + slab(-hole, hole, -40, -hole, 1) + slab(-hole, hole, hole, 40, 1);
  return out;
}
constexpr double HOLE_RADIANCE = 0.8 * 10 / PI_D;

/** Form factor from the middle of the floor to the hole: four times a rectangle parallel to a small element
 * (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-4). */
inline double holeFormFactor(double hole) {
  const double a = hole / std::sqrt(1 + hole * hole);
  return 4 / (2 * PI_D) * 2 * a * std::atan(a);
}

} // namespace recurse::testing
