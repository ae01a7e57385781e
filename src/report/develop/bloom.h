/** @file
 * Glare of the eye as a point-spread function: Spencer et al. 1995, "Physically-Based Glare Effects for
 * Digital Images".
 */
#pragma once

#include "recurse/core/image/image.h"

namespace recurse {

/** Photopic point-spread function of the paper (equations 1 to 3 and 5) at an angle from the light
 * [degrees], as light per steradian. */
double glareAt(double degrees);

/**
 * Spreads the fraction `amount`, in [0, 1], of R, G and B by the glare of an eye in front of which the
 * picture is `degrees` wide. The sum of the picture is preserved: light that would leave it is mirrored at
 * the border, because there is light outside as well. Returns the fraction of a pixel's light that stays in
 * the pixel; light from other pixels is the glare.
 */
double applyBloom(Image& picture, double amount, double degrees);

} // namespace recurse
