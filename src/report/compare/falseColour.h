/** @file
 * Scale of false colours.
 */
#pragma once

#include "recurse/core/math/rgb.h"

namespace recurse {

/** Perceptually uniform colours from dark violet (0) over green to yellow (1), in linear Rec. 709. */
Rgb falseColour(float t);

} // namespace recurse
