/** @file
 * False colours. Both scales are curves in Oklab (Ottosson 2020, "A perceptual color space for image
 * processing"), where equal steps look about equally large.
 */
#include "recurse/core/io/error.h"
#include "recurse/report/compare/compare.h"
#include "report/compare/falseColour.h"

namespace recurse {

namespace {

/** Converts lightness, chroma and hue (in turns) to linear Rec. 709; chroma is reduced to fit the gamut. */
Rgb rgbFromOklch(float lightness, float chroma, float hue) {
  const auto convert = [&](float c) {
    const float a = c * std::cos(2 * PI * hue), b = c * std::sin(2 * PI * hue);
    const float l = lightness + 0.3963377774f * a + 0.2158037573f * b;
    const float m = lightness - 0.1055613458f * a - 0.0638541728f * b;
    const float s = lightness - 0.0894841775f * a - 1.2914855480f * b;
    const float l3 = l * l * l, m3 = m * m * m, s3 = s * s * s;
    return Rgb(4.0767416621f * l3 - 3.3077115913f * m3 + 0.2309699292f * s3,
               -1.2684380046f * l3 + 2.6097574011f * m3 - 0.3413193965f * s3,
               -0.0041960863f * l3 - 0.7034186147f * m3 + 1.7076147010f * s3);
  };
  const auto inGamut = [](const Rgb& c) { return c.r >= 0 && c.g >= 0 && c.b >= 0 && maxComponent(c) <= 1; };
  float low = 0, high = chroma;
  if (inGamut(convert(chroma))) return convert(chroma);
  for (int i = 0; i < 12; ++i) { // grey is always inside
    const float middle = 0.5f * (low + high);
    (inGamut(convert(middle)) ? low : high) = middle;
  }
  return clamp(convert(low), 0, 1);
}

} // namespace

Rgb falseColour(float t) {
  t = std::clamp(t, 0.0f, 1.0f);
  return rgbFromOklch(0.22f + 0.70f * t, 0.13f + 0.05f * t, 0.83f - 0.53f * t);
}

Rgb divergingColour(float t) {
  t = std::clamp(t, -1.0f, 1.0f);
  const float amount = std::abs(t);
  return rgbFromOklch(0.92f - 0.45f * amount, 0.22f * amount, t < 0 ? 0.71f : 0.07f);
}

Image errorMap(const Image& image, const Image& reference, ErrorMap kind) {
  if (image.width != reference.width || image.height != reference.height)
    throw Error("the pictures differ in size: an error map needs equal sizes");
  Image map(image.width, image.height, {"R", "G", "B"});
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Rgb value = image.rgb(x, y), r = reference.rgb(x, y);
      float relative = 0;
      for (int c = 0; c < 3; ++c) {
        const float difference = (value[c] - r[c]) / (std::abs(r[c]) + float(MAPE_EPSILON));
        relative += (kind == ErrorMap::SIGNED ? difference : std::abs(difference)) / 3;
      }
      Rgb colour(1, 0, 1);
      if (std::isfinite(relative))
        colour = kind == ErrorMap::SIGNED ? divergingColour(2 * relative)
                                          : falseColour(1 + std::log10(std::max(relative, 1e-6f)) / 3);
      for (int c = 0; c < 3; ++c) map.at(x, y)[c] = colour[c];
    }
  return map;
}

} // namespace recurse
