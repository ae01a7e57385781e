/** @file
 * Colour triples: linear Rec. 709 primaries, D65 white. Radiance, flux, albedo and throughput are all Rgb.
 */
#pragma once

#include "recurse/core/vector.h"

namespace recurse {

using Rgb = glm::vec3;
using Rgbd = glm::dvec3;

constexpr Rgb BLACK{0, 0, 0};

/** Relative luminance Y of linear Rec. 709 (ITU-R BT.709-6, item 3.2). */
inline float luminance(const Rgb& c) { return 0.2126f * c.r + 0.7152f * c.g + 0.0722f * c.b; }
inline float maxComponent(const Rgb& c) { return std::max(c.r, std::max(c.g, c.b)); }
inline bool isBlack(const Rgb& c) { return c.r == 0 && c.g == 0 && c.b == 0; }

} // namespace recurse
