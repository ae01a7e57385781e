/** @file
 * The steps of developing a picture.
 */
#include "recurse/report/develop.h"

#include <algorithm>
#include <cmath>

#include "recurse/model/toneCurve.h"
#include "recurse/report/bloom.h"

namespace recurse {

namespace {

/** R, G and B alone, with black for what is not a colour. */
Image colourOf(const Image& picture) {
  Image out(picture.width, picture.height, {"R", "G", "B"});
  out.metadata = picture.metadata;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const Rgb c = picture.rgb(x, y);
      const bool finite = std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b);
      for (int i = 0; i < 3; ++i) out.at(x, y)[i] = finite ? std::max(c[i], 0.0f) : 0;
    }
  return out;
}

/** Luminances above zero, from dark to bright. */
std::vector<float> litLuminances(const Image& picture) {
  std::vector<float> lit = luminances(picture);
  std::erase_if(lit, [](float y) { return !(y > 0) || !std::isfinite(y); });
  std::sort(lit.begin(), lit.end());
  return lit;
}

float quantile(const std::vector<float>& sorted, double q) {
  return sorted[size_t(q * double(sorted.size() - 1))];
}

/** Shifts each value by less than a step of 8 bits, so that rounding keeps the mean: the additive recurrence
 * of Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences", whose values lie evenly in
 * every neighbourhood. Black and white stay what they are. */
void addDither(Image& picture) {
  const size_t stride = picture.channels.size();
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      for (size_t c = 0; c < stride; ++c) {
        const double u = 0.7548776662466927 * x + 0.5698402909980532 * y + double(c) / 3;
        float& value = picture.at(x, y)[c];
        if (value > 0 && value < 1) value += static_cast<float>((u - std::floor(u) - 0.5) / 255);
      }
}

} // namespace

double meteredStops(const Image& picture) {
  std::vector<float> lit = litLuminances(picture);
  if (lit.empty()) return 0;
  // Five stops below the bright parts a picture counts as dark, how dark does not matter.
  const float dark = quantile(lit, 0.95) / 32;
  const double low = std::log2(std::max(quantile(lit, 0.05), dark));
  const double high = std::log2(quantile(lit, 0.95));
  double sum = 0;
  for (float y : lit) sum += std::clamp(std::log2(double(y)), low, high);
  const double average = sum / double(lit.size());
  const double key = high > low ? (2 * average - low - high) / (high - low) : 0; // -1 dark, 1 bright
  return std::log2(double(GREY_CARD)) + key - average;
}

double stopsFor(const Exposure& exposure, const Image& picture) {
  double metered = 0;
  if (exposure.meter == Exposure::Meter::LOG_AVERAGE) metered = meteredStops(picture);
  if (exposure.meter == Exposure::Meter::PERCENTILE) {
    const std::vector<float> lit = litLuminances(picture);
    if (!lit.empty()) metered = -std::log2(double(quantile(lit, exposure.percentile / 100)));
  }
  return metered + exposure.stops;
}

Developed beforeExposure(const Image& picture, const DevelopSettings& settings) {
  Developed out{colourOf(picture), 0};
  applyWhiteBalance(out.picture, settings.whiteBalance);
  out.stops = stopsFor(settings.exposure, out.picture);
  applyBloom(out.picture, settings.bloom, settings.bloomDegrees);
  return out;
}

Developed develop(const Image& picture, const DevelopSettings& settings) {
  Developed out{colourOf(picture), 0};
  applyWhiteBalance(out.picture, settings.whiteBalance);
  out.stops = stopsFor(settings.exposure, out.picture);
  const float scale = static_cast<float>(std::exp2(out.stops));
  constexpr float LARGEST = 1e9f; // operators square their values
  for (float& value : out.picture.pixels) value = std::min(value * scale, LARGEST);
  applyBloom(out.picture, settings.bloom, settings.bloomDegrees);
  if (settings.toneMap && !settings.toneMap->isIdentity()) {
    const Image light = out.picture;
    settings.toneMap->apply(out.picture);
    mixBrightEdges(light, out.picture);
  }
  settings.display.apply(out.picture);
  if (settings.dither) addDither(out.picture);
  return out;
}

} // namespace recurse
