/** @file
 * Contact sheet of tone operators.
 */
#include <algorithm>
#include <cmath>

#include "recurse/model/scene/plugIns.h"
#include "recurse/report/develop/develop.h"
#include "report/page/bitmapFont.h"

namespace recurse {

namespace {

constexpr int SPACING = 8, LETTER_SIZE = 2, CAPTION = LINE_STEP * LETTER_SIZE + SPACING;
constexpr int LARGEST = 480; ///< side of a picture in the sheet [pixels]

/** Linear means of the finite pixels of square blocks, so that the longer side is at most LARGEST. */
Image reduced(const Image& picture) {
  const int block = (std::max(picture.width, picture.height) + LARGEST - 1) / LARGEST;
  Image out(std::max(1, picture.width / block), std::max(1, picture.height / block), {"R", "G", "B"});
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      Rgb sum{0};
      int count = 0;
      for (int j = 0; j < block; ++j)
        for (int i = 0; i < block; ++i) {
          const Rgb c = picture.rgb(std::min(x * block + i, picture.width - 1),
                                    std::min(y * block + j, picture.height - 1));
          if (!isFinite(c)) continue;
          sum += c;
          ++count;
        }
      if (count > 0) sum /= float(count);
      std::copy_n(&sum.r, 3, out.at(x, y));
    }
  return out;
}

} // namespace

Developed operatorSheet(const Image& picture, const DevelopSettings& settings) {
  const auto& operators = plugIns().toneMaps.entries();
  const Image small = reduced(picture);
  int width = small.width;
  for (const auto& entry : operators)
    width = std::max(width, int(entry.name.size()) * LETTER_STEP * LETTER_SIZE);
  const int cellWidth = width + SPACING, cellHeight = small.height + CAPTION;
  // Columns for an aspect ratio of about 3:2.
  const double count = double(operators.size());
  const int columns =
      std::clamp(int(std::lround(std::sqrt(1.5 * count * cellHeight / cellWidth))), 1, int(count));
  const int rows = (int(operators.size()) + columns - 1) / columns;
  Developed sheet{Image(columns * cellWidth + SPACING, rows * cellHeight + SPACING, {"R", "G", "B"}), 0};
  std::fill(sheet.picture.pixels.begin(), sheet.picture.pixels.end(), 0.1f);
  sheet.picture.metadata = picture.metadata;
  for (size_t i = 0; i < operators.size(); ++i) {
    DevelopSettings one = settings;
    Diagnostics diagnostics;
    one.toneMap =
        plugIns().toneMaps.make(parseParameterText(operators[i].name, ""), NoContext{}, diagnostics);
    const Developed developed = develop(small, one);
    sheet.stops = developed.stops;
    const int left = SPACING + int(i) % columns * cellWidth, top = SPACING + int(i) / columns * cellHeight;
    for (int y = 0; y < small.height; ++y)
      for (int x = 0; x < small.width; ++x)
        std::copy_n(developed.picture.at(x, y), 3, sheet.picture.at(left + x, top + y));
    drawText(sheet.picture, left, top + small.height + SPACING / 2, operators[i].name, Rgb(0.9f),
             LETTER_SIZE);
  }
  return sheet;
}

} // namespace recurse
