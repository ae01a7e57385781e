/** @file
 * Tone operators: mapping of scene radiance to the range of a display.
 */
#pragma once

#include "recurse/core/image/image.h"

namespace recurse {

/** Reflectance of the photographer's grey card. Exposure maps middle grey to it, and every operator leaves an
 * image of that grey unchanged. */
constexpr float GREY_CARD = 0.18f;

class ToneMap {
 public:
  virtual ~ToneMap() = default;
  /**
   * Maps exposed colours to display colours, of which the display shows [0, 1] and clips larger values. Both
   * are linear Rec. 709 in the first three channels; the input is finite and not negative.
   */
  virtual void apply(Image& picture) const = 0;
  /** True where the result of a pixel depends on its neighbours. Otherwise the mapping is monotonic. */
  virtual bool isLocal() const { return false; }
  /** True where the mapping depends on statistics of the whole image, such as its brightest pixels. Refused
   * for animations, which would flicker. */
  virtual bool measuresPicture() const { return false; }
  /** True where the operator leaves the image unchanged. */
  virtual bool isIdentity() const { return false; }
  /** Halo: maximum relative difference between a pixel beside an edge of 1:100 and one far from the edge. */
  virtual float haloBound() const { return 0; }
};

} // namespace recurse
