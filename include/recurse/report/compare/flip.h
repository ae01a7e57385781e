/** @file
 * FLIP, the difference that a person sees who switches between two pictures. LDR-FLIP after Andersson et al.
 * 2020, "FLIP: A Difference Evaluator for Alternating Images"; HDR-FLIP after Andersson et al. 2021,
 * "Visualizing Errors in Rendered High Dynamic Range Images".
 */
#pragma once

#include <vector>

#include "recurse/core/image/image.h"

namespace recurse {

/** Pixels per degree of vision: the papers' default, a display 0.7 m and 3840 pixels wide, seen from 0.7 m.
 */
constexpr double FLIP_PIXELS_PER_DEGREE = 3840 * 3.14159265358979323846 / 180;

/** The error of each pixel, row by row, and their mean: 0, nothing seen, to 1. */
struct Flip {
  int width = 0, height = 0;
  std::vector<float> errors; ///< empty where a pixel of either picture is not finite
  double mean = 0;           ///< NaN then
  /** HDR-FLIP: the exposures in stops, from the shortest to the longest. */
  std::vector<double> exposures;
};

/** Of linear pictures as a display shows them without exposure, which is cut to [0, 1]. Throws Error where
 * the sizes differ. */
Flip ldrFlip(const Image& image, const Image& reference, double pixelsPerDegree = FLIP_PIXELS_PER_DEGREE);

/**
 * The largest LDR-FLIP of each pixel over a range of exposures with the ACES tone curve: from the one that
 * shows the reference's largest luminance as 0.85 to the one that does so with its median, in steps of one
 * stop at the most. Negative values count as zero. Where the median is zero, which the paper leaves open, it
 * is the median of the luminances above zero.
 */
Flip hdrFlip(const Image& image, const Image& reference, double pixelsPerDegree = FLIP_PIXELS_PER_DEGREE);

/** The errors in false colours. Throws Error where there are none. */
Image flipMap(const Flip& flip);

} // namespace recurse
