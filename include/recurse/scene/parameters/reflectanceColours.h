/** @file
 * Colours of many reflectances sampled at the same wavelengths.
 */
#pragma once

#include <vector>

#include "recurse/core/math/rgb.h"

namespace recurse {

/** Weights of the samples of a reflectance: the sum of weights times samples is the colour of rgbOfSpectrum()
 * before it is moved into the gamut. Wavelengths [nm] increase; at least one. */
std::vector<Rgbd> reflectanceColours(const std::vector<double>& wavelengths);

/** Colour without negative components: moved towards the grey of its luminance; black where the luminance is
 * not above zero. */
Rgbd intoGamut(const Rgbd& colour);

} // namespace recurse
