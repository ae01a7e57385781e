/** @file
 * Detection of the encoding, flip and shift of a picture, before its light is compared.
 */
#pragma once

#include "recurse/report/marking/marking.h"

namespace recurse {

struct Alignment {
  PictureChange change;
  std::vector<double> factors; ///< factors of the classes by least squares over the picture, none negative
};

/** Changes that may have been made, the most probable of each encoding among them. The sum of the classes,
 * each with a factor, is fitted to the picture. The first has no change. */
std::vector<Alignment> findAlignments(const Image& picture, const Stills& reference);

/** Factors of the classes that fit a linear picture, aligned with the reference. */
std::vector<double> fittedFactors(const Image& picture, const Stills& reference);

/** −2 ln of the prior probability of a change of a picture of this size. */
double priorScore(const PictureChange& change, int width, int height);

/** Parts of a picture whose differences from a reference are independent of each other. */
constexpr double PATCHES = 48;

/** Picture with the change undone: R, G, B; NaN where it has no pixel. */
Image undone(const Image& picture, const PictureChange& change);

/** Decodes a value that should be linear. */
float decoded(float value, ValueEncoding encoding);
/** Encodes a linear value; the inverse of decoded(). */
float encoded(float linear, ValueEncoding encoding);

/** Factors of least squares that are not negative: minimises f'Nf - 2b'f. N is symmetric, row by row. */
std::vector<double> nonNegativeFactors(const std::vector<double>& matrix, const std::vector<double>& vector);

} // namespace recurse
