/** @file
 * Curve of an unknown tone operator, found from a picture and its reference.
 */
#pragma once

#include <vector>

#include "recurse/core/image/image.h"

namespace recurse {

/** What a curve applies to. */
enum class CurveDomain {
  CHANNELS, ///< each channel by itself
  LUMINANCE ///< the luminance, while hue and saturation are kept
};

/** Monotone curve from light to the values of a picture: a monotone cubic between knots in logarithms of
 * both. */
class FittedCurve {
 public:
  static constexpr size_t KNOTS = 6;

  /** Fits the curve to means over squares of pixels; NaN is left out. */
  FittedCurve(const Image& picture, const Image& light, CurveDomain domain, int side);

  bool isKnown() const { return !knots.empty(); }
  /** Picture that the curve makes of light, R, G, B. */
  Image shown(const Image& light) const;
  /** Light of a picture. */
  Image light(const Image& picture) const;

 private:
  struct Knot {
    double light, value; ///< logarithms
  };

  template <class Curve> Image mapped(const Image& image, const Curve& curve) const;

  CurveDomain domain;
  std::vector<Knot> knots; ///< both coordinates increase
};

} // namespace recurse
