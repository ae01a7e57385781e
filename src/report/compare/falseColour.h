/** @file
 * Scale of false colours.
 */
#pragma once

#include "recurse/core/math/rgb.h"

namespace recurse {

/** Perceptually uniform colours from dark violet (0) over green to yellow (1), in linear Rec. 709. */
Rgb falseColour(float t);

/** Diverging colours: blue (-1), light grey (0), red (1), in linear Rec. 709. */
Rgb divergingColour(float t);

} // namespace recurse
