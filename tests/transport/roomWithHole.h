/** @file
 * A closed room whose only light enters through a hole in its roof.
 */
#pragma once

#include "transport/rendering.h"

namespace recurse::testing {

constexpr float HOLE_HALF_WIDTH = 0.2f; ///< half width of the hole, which is 1.25 above the centre

/** Room in uniform light from all directions. `pane`: more shapes. */
inline std::string roomWithHole(int width, const std::string& pane = "") {
  return view(width, "-1.6 1.3 -1.8  1 .5 1  0 1 0", 60) + R"(
LightSource "infinite" "rgb L" [1 1 1]
Material "diffuse" "rgb reflectance" [.7 .7 .7]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3 4 5 1 4 1 0 5 6 2 5 2 1 6 7 3 6 3 2 7 4 0 7 0 3]
  "point3 P" [-2 0 -2  2 0 -2  2 0 2  -2 0 2  -2 2.5 -2  2 2.5 -2  2 2.5 2  -2 2.5 2]
Shape "trianglemesh" "integer indices" [0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7]
  "point3 P" [-2 2.5 -2  2 2.5 -2  2 2.5 2  -2 2.5 2  -.2 2.5 -.2  .2 2.5 -.2  .2 2.5 .2  -.2 2.5 .2]
)" + pane;
}

/** Whether the line of a ray crosses the roof within the hole; `center`: centre of the room. */
inline bool crossesHole(const Vec3f& origin, const Vec3f& direction, const Vec3f& center) {
  const Vec3f at = origin + direction * ((center.y + 1.25f - origin.y) / direction.y) - center;
  return std::abs(at.x) < HOLE_HALF_WIDTH && std::abs(at.z) < HOLE_HALF_WIDTH;
}

} // namespace recurse::testing
