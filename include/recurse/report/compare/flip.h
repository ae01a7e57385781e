/** @file
 * FLIP: the difference perceived when alternating between two pictures. LDR-FLIP after Andersson et al. 2020,
 * "FLIP: A Difference Evaluator for Alternating Images"; HDR-FLIP after Andersson et al. 2021, "Visualizing
 * Errors in Rendered High Dynamic Range Images".
 */
#pragma once

#include <vector>

#include "recurse/core/image/image.h"

namespace recurse {

/** Pixels per degree of visual angle: the papers' default, a display 0.7 m and 3840 pixels wide, seen from
 * 0.7 m. */
constexpr double FLIP_PIXELS_PER_DEGREE = 3840 * 3.14159265358979323846 / 180;

/** Error of each pixel, row by row, and their mean; from 0, not visible, to 1. */
struct Flip {
  int width = 0, height = 0;
  std::vector<float> errors; ///< empty if any pixel of either picture is not finite
  double mean = 0;           ///< NaN if `errors` is empty
  /** Exposures of HDR-FLIP, from the shortest to the longest [stops]; empty: LDR-FLIP. */
  std::vector<double> exposures;
};

/** LDR-FLIP of linear pictures as displayed without exposure, clipped to [0, 1]. Throws Error where the
 * sizes differ, or a picture has fewer than three channels. */
Flip ldrFlip(const Image& image, const Image& reference, double pixelsPerDegree = FLIP_PIXELS_PER_DEGREE);

/**
 * HDR-FLIP: maximum LDR-FLIP of each pixel over a range of exposures with the ACES tone curve. The first
 * exposure maps the reference's largest luminance to 0.85, the last one its median; there is an exposure for
 * each stop of this range, rounded up, and at least two; for a black reference, one of 0 stops. Negative
 * values count as zero. Where the median is zero, which the paper does not treat, the median of the positive
 * luminances is used. Throws Error as ldrFlip() does.
 */
Flip hdrFlip(const Image& image, const Image& reference, double pixelsPerDegree = FLIP_PIXELS_PER_DEGREE);

/** Errors in false colours. Throws Error where there are none. */
Image flipMap(const Flip& flip);

} // namespace recurse
