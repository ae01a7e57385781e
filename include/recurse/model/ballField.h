/** @file
 * Fields of metaballs: how they fall off with q, the squared distance in radii, from 1 in the middle to 0 at
 * q = 1.
 */
#pragma once

#include <string>

#include "recurse/core/vector.h"

namespace recurse {

/** As POV-Ray's blobs. */
inline double quarticField(double q) { return square(1 - q); }

/** 1 - 22/9 q + 17/9 q² - 4/9 q³ (Wyvill, McPheeters, Wyvill, "Data Structure for Soft Objects", 1986). */
inline double wyvillField(double q) { return 1 + q * (-22 + q * (17 - 4 * q)) / 9; }

/** Blinn's exp(-4 q) (1982, "A Generalization of Algebraic Surface Drawing"), let down to 0 at q = 1 as
 * (1 - q)² ((1 - q)² + q²), which keeps its slope in the middle and is nowhere off by more than 0.02. */
inline double blinnField(double q) { return square(1 - q) * (square(1 - q) + square(q)); }

using BallField = double (*)(double q);
/** One of these by its name in scene files. */
inline BallField ballField(const std::string& name) {
  return name == "wyvill" ? wyvillField : name == "blinn" ? blinnField : quarticField;
}

} // namespace recurse
