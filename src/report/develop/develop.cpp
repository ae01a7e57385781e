/** @file
 * Steps of developing a picture.
 */
#include "recurse/report/develop/develop.h"

#include <algorithm>
#include <cmath>

#include "recurse/model/film/toneCurve.h"
#include "report/develop/bloom.h"

namespace recurse {

namespace {

/** R, G and B alone; pixels that are not finite are black, negative values 0. */
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

/** A luminance, and how many pixels have it. */
struct Metered {
  float luminance;
  double weight;
};

/** Rectangle of pixels; right and bottom are excluded. */
struct Window {
  int left, top, right, bottom;
  void add(int x, int y) {
    left = std::min(left, x), right = std::max(right, x + 1);
    top = std::min(top, y), bottom = std::max(bottom, y + 1);
  }
};

/**
 * Metering field: means over small squares, because the logarithm of noise is too low. Black around the lit
 * part is excluded; pixels far brighter than everything around them, such as lamps, are not in the means.
 */
class MeterField {
 public:
  explicit MeterField(const Image& picture)
      : width(picture.width), height(picture.height), values(luminances(picture)) {
    const Window lit = litPart({0, 0, picture.width, picture.height});
    constexpr int SQUARES = 24; // squares along the longer side
    const int side = std::max(1, std::max(lit.right - lit.left, lit.bottom - lit.top) / SQUARES);
    for (int y = lit.top; y < lit.bottom; y += side)
      for (int x = lit.left; x < lit.right; x += side) {
        // Black between lit pixels is noise; black beyond them is background.
        const Window around =
            litPart({std::max(x - side, lit.left), std::max(y - side, lit.top),
                     std::min(x + 2 * side, lit.right), std::min(y + 2 * side, lit.bottom)});
        squares.push_back({std::max(x, around.left), std::max(y, around.top),
                           std::min(x + side, around.right), std::min(y + side, around.bottom)});
      }
  }

  /** Metered luminances from dark to bright. */
  std::vector<Metered> metered() const;

 private:
  float at(int x, int y) const { return values[size_t(y) * size_t(width) + size_t(x)]; }
  /** Smallest window within `in` that contains all its pixels above zero. */
  Window litPart(const Window& in) const {
    Window out{in.right, in.bottom, in.left, in.top};
    for (int y = in.top; y < in.bottom; ++y)
      for (int x = in.left; x < in.right; ++x)
        if (at(x, y) > 0 && std::isfinite(at(x, y))) out.add(x, y);
    return out;
  }
  /** Whether a pixel and two or more neighbours are brighter than `lamp`: an isolated one is noise. */
  bool isLamp(int x, int y, float lamp) const {
    if (!(at(x, y) > lamp)) return false;
    int bright = -1; // itself
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, height - 1); ++j)
      for (int i = std::max(x - 1, 0); i <= std::min(x + 1, width - 1); ++i) bright += at(i, j) > lamp;
    return bright >= 2;
  }
  /** Means over the squares without lamps, and the pixels of lamps separately. */
  std::vector<Metered> means(float lamp) const {
    std::vector<Metered> out;
    for (const Window& w : squares) {
      double sum = 0, count = 0;
      for (int y = w.top; y < w.bottom; ++y)
        for (int x = w.left; x < w.right; ++x) {
          const float v = at(x, y);
          if (!std::isfinite(v)) continue;
          if (isLamp(x, y, lamp)) {
            out.push_back({v, 1});
          } else {
            sum += double(std::max(v, 0.0f));
            ++count;
          }
        }
      if (sum > 0) out.push_back({static_cast<float>(sum / count), count});
    }
    std::sort(out.begin(), out.end(),
              [](const Metered& a, const Metered& b) { return a.luminance < b.luminance; });
    return out;
  }

  int width, height;
  std::vector<float> values;
  std::vector<Window> squares;
};

/** Luminance below which the fraction q of the weight is. */
float quantile(const std::vector<Metered>& sorted, double q) {
  double total = 0;
  for (const Metered& m : sorted) total += m.weight;
  double below = 0;
  for (const Metered& m : sorted)
    if ((below += m.weight) > q * total) return m.luminance;
  return sorted.empty() ? 0 : sorted.back().luminance;
}

std::vector<Metered> MeterField::metered() const {
  constexpr float LAMP = 32; // five stops above the upper quartile of the picture
  const std::vector<Metered> all = means(INFINITE);
  return all.empty() ? all : means(LAMP * quantile(all, 0.75));
}

float quantile(const std::vector<float>& sorted, double q) {
  return sorted[size_t(q * double(sorted.size() - 1))];
}

/** Dithers each value by less than a step of 8 bits, so that rounding keeps the mean: the additive
 * recurrence of Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences", whose values are
 * evenly distributed in every neighbourhood. Black and white are not changed. */
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
  const std::vector<Metered> lit = MeterField(picture).metered();
  if (lit.empty()) return 0;
  // Luminances more than five stops below the bright parts count as equally dark.
  const float dark = quantile(lit, 0.95) / 32;
  const double low = std::log2(std::max(quantile(lit, 0.05), dark));
  const double high = std::log2(quantile(lit, 0.95));
  double sum = 0, weight = 0;
  for (const Metered& m : lit) {
    sum += m.weight * std::clamp(std::log2(double(m.luminance)), low, high);
    weight += m.weight;
  }
  const double average = sum / weight;
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

Glaring withGlare(Image picture, double amount, double degrees) {
  Glaring out{picture, std::move(picture)};
  const auto kept = static_cast<float>(applyBloom(out.light, amount, degrees));
  for (float& value : out.direct.pixels) value *= kept;
  return out;
}

Unexposed beforeExposure(const Image& picture, const DevelopSettings& settings) {
  Image balanced = colourOf(picture);
  applyWhiteBalance(balanced, settings.whiteBalance);
  const double stops = stopsFor(settings.exposure, balanced);
  return {withGlare(std::move(balanced), settings.bloom, settings.bloomDegrees), stops};
}

Developed develop(const Image& picture, const DevelopSettings& settings) {
  Developed out{colourOf(picture), 0};
  applyWhiteBalance(out.picture, settings.whiteBalance);
  out.stops = stopsFor(settings.exposure, out.picture);
  const float scale = static_cast<float>(std::exp2(out.stops));
  constexpr float LARGEST = 1e9f; // operators square their values
  for (float& value : out.picture.pixels) value = std::min(value * scale, LARGEST);
  const Glaring exposed = withGlare(std::move(out.picture), settings.bloom, settings.bloomDegrees);
  out.picture = exposed.light;
  if (settings.toneMap && !settings.toneMap->isIdentity()) {
    settings.toneMap->apply(out.picture);
    mixBrightEdges(exposed, out.picture);
  }
  settings.display.apply(out.picture);
  if (settings.dither) addDither(out.picture);
  return out;
}

} // namespace recurse
