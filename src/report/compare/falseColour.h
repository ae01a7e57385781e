/** @file
 * The scale of false colours.
 */
#pragma once

#include "recurse/core/math/rgb.h"

namespace recurse {

/** Perceptually even colours from dark violet (0) over green to yellow (1), as sRGB made linear. */
Rgb falseColour(float t);

} // namespace recurse
