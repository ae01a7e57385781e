/** @file
 * Weights that turn a sampled reflectance into a colour. Implemented in spectrum.cpp.
 */
#pragma once

#include <vector>

#include "recurse/core/math/rgb.h"

namespace recurse {

/** Weights of the samples of a reflectance: the sum of weights times samples is the colour of rgbOfSpectrum()
 * before it is moved into the gamut. Wavelengths [nm] increase; at least one. */
std::vector<Rgbd> reflectanceWeights(const std::vector<double>& wavelengths);

/** Colour without negative components: moved towards the grey of its luminance; black where the luminance is
 * not above zero. */
Rgbd intoGamut(const Rgbd& colour);

} // namespace recurse
