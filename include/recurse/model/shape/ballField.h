/** @file
 * Fields of metaballs: falloff as a function of q, the squared distance over the squared radius, from 1 at
 * the centre to 0 at q = 1. The functions are for q in [0, 1].
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/core/math/vector.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Field of POV-Ray's blobs: (1 - q)². */
inline double quarticField(double q) { return square(1 - q); }

/** Field of Blender's metaballs: (1 - q)³. */
inline double sexticField(double q) { return (1 - q) * square(1 - q); }

/** 1 - 22/9 q + 17/9 q² - 4/9 q³ (Wyvill, McPheeters, Wyvill, "Data Structure for Soft Objects", 1986). */
inline double wyvillField(double q) { return 1 + q * (-22 + q * (17 - 4 * q)) / 9; }

/** Blinn's field exp(-4 q) (1982, "A Generalization of Algebraic Surface Drawing"), made to reach 0 at q = 1
 * by (1 - q)² ((1 - q)² + q²), which has the same slope at the centre and differs by up to 0.0201. */
inline double blinnField(double q) { return square(1 - q) * (square(1 - q) + square(q)); }

using BallField = double (*)(double q);
/** Field by its name in scene files; quarticField() for an unknown name. */
inline BallField ballField(const std::string& name) {
  return name == "sextic"   ? sexticField
         : name == "wyvill" ? wyvillField
         : name == "blinn"  ? blinnField
                            : quarticField;
}

/** Throws SceneError, with what would be accepted, unless a parameter has one value for each position of "P".
 * `found`: number of its values. */
inline void requireEach(const Parameters& p, const char* name, size_t found, size_t positions,
                        const char* accepted = "one for each element of \"P\"") {
  if (found != positions)
    p.fail(name, std::to_string(found) + " given for " + std::to_string(positions) + " positions", accepted);
}
/** Values of a parameter for each of `count` balls; a single value applies to all. Throws SceneError for any
 * other number of values. */
inline std::vector<double> numbersOfBalls(const Parameters& p, const char* name, size_t count) {
  std::vector<double> values = p.reals(name);
  if (values.size() == 1) values.assign(count, values.front());
  requireEach(p, name, values.size(), count, "one for all, or one for each element of \"P\"");
  return values;
}

} // namespace recurse
