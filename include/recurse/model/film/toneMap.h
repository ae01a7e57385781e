/** @file
 * Tone operators: from light in the scene to what a display can show.
 */
#pragma once

#include "recurse/core/image/image.h"

namespace recurse {

/** Reflectance of the photographer's grey card. Exposure puts middle grey there, and every operator leaves a
 * picture of that grey as it is. */
constexpr float GREY_CARD = 0.18f;

class ToneMap {
 public:
  virtual ~ToneMap() = default;
  /**
   * Turns exposed colours into those of a display, which shows [0, 1] and cuts what is over. Both are linear
   * Rec. 709 in the first three channels; what comes in is finite and not negative.
   */
  virtual void apply(Image& picture) const = 0;
  /** The result for a pixel depends on its surroundings. Otherwise a brighter pixel never becomes darker. */
  virtual bool isLocal() const { return false; }
  /** Colours stay what they are, and nothing else is done to the picture either. */
  virtual bool isIdentity() const { return false; }
  /** How far a pixel beside an edge of 1:100 may be from one far off, relative to the latter. */
  virtual float haloBound() const { return 0; }
};

} // namespace recurse
