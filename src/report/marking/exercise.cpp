/** @file
 * Clipped pixels of an exercise, and the side of its cells.
 */
#include "report/marking/exercise.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace recurse {

namespace {

/** Regions along the longer side of the picture, where it has enough pixels. */
constexpr int REGIONS = 20;

/** Difference of the last two steps of eight bits, halved. */
constexpr float LAST_STEP = 1 / 512.0f;

Image clippedPixels(const Image& picture) {
  Image out(picture.width, picture.height, {"R", "G", "B"});
  if (!picture.fromIntegers) return out;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      std::fill_n(out.at(x, y), 3, maxComponent(picture.rgb(x, y)) >= 1 - LAST_STEP ? 1.0f : 0.0f);
  return out;
}

/** Picture with NaN around clipped pixels. Single pixels that noise made white stay, and the decision is made
 * by many pixels: leaving out those that are bright by chance would make the others seem too dark. */
Image withoutClipped(const Image& picture, const Image& clipped) {
  constexpr int REACH = 2;
  constexpr float MOST_CLIPPED = 0.1f;
  Image out = picture;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      float sum = 0, count = 0;
      for (int j = std::max(y - REACH, 0); j <= std::min(y + REACH, picture.height - 1); ++j)
        for (int i = std::max(x - REACH, 0); i <= std::min(x + REACH, picture.width - 1); ++i, ++count)
          sum += clipped.at(i, j)[0];
      if (sum > MOST_CLIPPED * count) std::fill_n(out.at(x, y), 3, std::numeric_limits<float>::quiet_NaN());
    }
  return out;
}

int cellSide(const Image& picture) {
  const double longer = std::max(picture.width, picture.height);
  return std::max(2, 2 * static_cast<int>(std::lround(longer / (2 * REGIONS * REGION_CELLS))));
}

} // namespace

Exercise::Exercise(const Image& picture, const Stills& reference)
    : picture(picture), reference(reference), clipped(clippedPixels(picture)),
      usable(withoutClipped(picture, clipped)), side(cellSide(picture)), layers(reference.layers.size() - 1) {
}

double Exercise::clippedFraction() const {
  return std::accumulate(clipped.pixels.begin(), clipped.pixels.end(), 0.0) / double(clipped.pixels.size());
}

Image withLoss(const Image& light, const Image& clipped, int regionSide) {
  Image out(light.width, light.height, {"R", "G", "B", "lost.R", "lost.G", "lost.B"});
  for (int top = 0; top < light.height; top += regionSide)
    for (int left = 0; left < light.width; left += regionSide) {
      const int bottom = std::min(top + regionSide, light.height),
                right = std::min(left + regionSide, light.width);
      Rgb lost(0);
      for (int y = top; y < bottom; ++y)
        for (int x = left; x < right; ++x)
          if (const Rgb value = light.rgb(x, y); clipped.at(x, y)[0] == 1 && isFinite(value)) lost += value;
      lost /= float((bottom - top) * (right - left));
      for (int y = top; y < bottom; ++y)
        for (int x = left; x < right; ++x) {
          std::copy_n(light.at(x, y), 3, out.at(x, y));
          std::copy_n(&lost.r, 3, out.at(x, y) + 3);
        }
    }
  return out;
}

} // namespace recurse
