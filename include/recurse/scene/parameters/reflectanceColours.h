/** @file
 * Colours of many reflectances that are sampled at the same wavelengths.
 */
#pragma once

#include <vector>

#include "recurse/core/math/rgb.h"

namespace recurse {

/** What each sample of a reflectance adds to its colour, which is rgbOfSpectrum's before it is moved into the
 * gamut. Wavelengths [nm] increase. */
std::vector<Rgbd> reflectanceColours(const std::vector<double>& wavelengths);

/** A colour with components below zero, moved towards the grey of its luminance; black where that is not
 * above zero. */
Rgbd intoGamut(const Rgbd& colour);

} // namespace recurse
