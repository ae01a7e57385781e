/** @file
 * Encoding, flip and shift of a picture, found before its light is looked at.
 */
#pragma once

#include "recurse/report/marking/marking.h"

namespace recurse {

struct Alignment {
  PictureChange change;
  double certainty = 0;        ///< probability of the change among all that were tried
  std::vector<double> factors; ///< of the classes, none negative, by least squares over the whole picture
};

/** Finds the change under which the sum of the classes, each by a factor, comes closest to the picture. */
Alignment findAlignment(const Image& picture, const Stills& reference);

/** The picture as it is, with the factors that come closest. */
Alignment unchanged(const Image& picture, const Stills& reference);

/** The picture with the change undone: R, G, B; NaN where there is nothing. */
Image undone(const Image& picture, const PictureChange& change);

/** Value at which a picture of a format for displays is clipped; infinite for any other. */
float clippingValue(const Image& picture);

/** A value that should be linear, decoded. */
float decoded(float value, ValueEncoding encoding);
/** The reverse. */
float encoded(float linear, ValueEncoding encoding);

/** Factors of least squares that are not negative: minimises f'Nf - 2b'f. N is symmetric, row by row. */
std::vector<double> nonNegativeFactors(const std::vector<double>& matrix, const std::vector<double>& vector);

} // namespace recurse
