/** @file
 * Glare of the eye as a point-spread function: Spencer et al. 1995, "Physically-Based Glare Effects for
 * Digital Images".
 */
#pragma once

#include "recurse/core/image/image.h"

namespace recurse {

/** The paper's photopic point-spread function (equations 1 to 3 and 5) at an angle from the light [degrees]:
 * the light per steradian. */
double glareAt(double degrees);

/**
 * Spreads the part `amount`, in [0, 1], of the light of R, G and B by the glare of an eye in front of which
 * the picture is `degrees` wide. The picture's sum stays the same: what would leave it comes back as from a
 * mirror at the border, for there is light outside as well. Returns the fraction of a pixel's light that
 * stays in the pixel; what comes from other pixels is the glare.
 */
double applyBloom(Image& picture, double amount, double degrees);

} // namespace recurse
