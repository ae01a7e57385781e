/** @file
 * Picture of an exercise, with the pixels that can be marked.
 */
#pragma once

#include "recurse/report/stills/stills.h"

namespace recurse {

/** Cells along a side of a region: 64 cells can separate ten classes, and localise mistakes well. */
constexpr int REGION_CELLS = 8;

struct Exercise {
  const Image& picture;
  const Stills& reference;
  Image clipped; ///< R, G, B: 1 where a channel of the pixel is clipped, else 0
  Image usable;  ///< R, G, B of the picture; NaN where it is clipped
  int side;      ///< side of a cell [pixels], even, so that both halves of the checkerboard are in each
  size_t layers; ///< number of classes

  Exercise(const Image& picture, const Stills& reference);
  /** Fraction of the pixels with a clipped channel. */
  double clippedFraction() const;
};

/** Light, and in three more channels the light that clipping may have removed: in each region as much as is
 * left in the single pixels that noise made white. All pixels of the region may lack it, because noisy light
 * is in few, bright ones. */
Image withLoss(const Image& light, const Image& clipped, int regionSide);

} // namespace recurse
