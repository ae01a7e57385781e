/** @file
 * Fields of metaballs: how they fall off with q, the squared distance in radii, from 1 in the middle to 0 at
 * q = 1.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/core/math/vector.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** As POV-Ray's blobs. */
inline double quarticField(double q) { return square(1 - q); }

/** As Blender's metaballs. */
inline double sexticField(double q) { return (1 - q) * square(1 - q); }

/** 1 - 22/9 q + 17/9 q² - 4/9 q³ (Wyvill, McPheeters, Wyvill, "Data Structure for Soft Objects", 1986). */
inline double wyvillField(double q) { return 1 + q * (-22 + q * (17 - 4 * q)) / 9; }

/** Blinn's exp(-4 q) (1982, "A Generalization of Algebraic Surface Drawing"), let down to 0 at q = 1 as
 * (1 - q)² ((1 - q)² + q²), which keeps its slope in the middle and is nowhere off by more than 0.02. */
inline double blinnField(double q) { return square(1 - q) * (square(1 - q) + square(q)); }

using BallField = double (*)(double q);
/** One of these by its name in scene files. */
inline BallField ballField(const std::string& name) {
  return name == "sextic"   ? sexticField
         : name == "wyvill" ? wyvillField
         : name == "blinn"  ? blinnField
                            : quarticField;
}

/** Fails unless a parameter has one value for each position of "P". */
inline void requireEach(const Parameters& p, const char* name, size_t found, size_t positions,
                        const char* accepted = "one for each element of \"P\"") {
  if (found != positions)
    p.fail(name, std::to_string(found) + " given for " + std::to_string(positions) + " positions", accepted);
}
/** A number for each of `count` balls, where one may be given for all. */
inline std::vector<double> numbersOfBalls(const Parameters& p, const char* name, size_t count) {
  std::vector<double> values = p.reals(name);
  if (values.size() == 1) values.assign(count, values.front());
  requireEach(p, name, values.size(), count, "one for all, or one for each element of \"P\"");
  return values;
}

} // namespace recurse
