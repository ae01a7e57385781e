/** @file
 * Detection of the encoding, flip and shift of a picture, before its light is compared.
 */
#pragma once

#include "recurse/report/marking/marking.h"

namespace recurse {

struct Alignment {
  PictureChange change;
  double certainty = 0;        ///< probability of the change among all candidates
  std::vector<double> factors; ///< factors of the classes by least squares over the picture, none negative
};

/** Finds the change under which the sum of the classes, each with a factor, fits the picture best. */
Alignment findAlignment(const Image& picture, const Stills& reference);

/** Alignment without a change, with the factors that fit best. */
Alignment unchanged(const Image& picture, const Stills& reference);

/** Picture with the change undone: R, G, B; NaN where it has no pixel. */
Image undone(const Image& picture, const PictureChange& change);

/** Value at which a picture of a format for displays is clipped; infinite for any other. */
float clippingValue(const Image& picture);

/** Decodes a value that should be linear. */
float decoded(float value, ValueEncoding encoding);
/** Encodes a linear value; the inverse of decoded(). */
float encoded(float linear, ValueEncoding encoding);

/** Factors of least squares that are not negative: minimises f'Nf - 2b'f. N is symmetric, row by row. */
std::vector<double> nonNegativeFactors(const std::vector<double>& matrix, const std::vector<double>& vector);

} // namespace recurse
