/** @file
 * Layout of figures.
 */
#include <algorithm>
#include <cmath>

#include "recurse/report/figures/figures.h"
#include "report/page/bitmapFont.h"

namespace recurse {

namespace {

constexpr int FIGURE_MARGIN = 12, FIGURE_TEXT = 1, FIGURE_TITLE = 2;
constexpr int NAME_HEIGHT = LINE_STEP * FIGURE_TEXT + 4, TITLE_HEIGHT = LINE_STEP * FIGURE_TITLE + 4;

} // namespace

Image figureSheet(const std::string& title, const std::string& subtitle,
                  const std::vector<FigurePanel>& panels) {
  float columns = 0;
  int rows = 0;
  for (const FigurePanel& p : panels) {
    columns = std::max(columns, p.column + 1);
    rows = std::max(rows, p.row + 1);
  }
  const int width = panels.front().image.width, height = panels.front().image.height;
  const int stepX = width + FIGURE_MARGIN, stepY = height + NAME_HEIGHT + FIGURE_MARGIN;
  const int top = FIGURE_MARGIN + TITLE_HEIGHT + NAME_HEIGHT;
  const int titleWidth = LETTER_STEP * std::max(FIGURE_TITLE * static_cast<int>(title.size()),
                                                FIGURE_TEXT * static_cast<int>(subtitle.size()));
  Image sheet(
      std::max(static_cast<int>(std::ceil(columns * static_cast<float>(stepX))), titleWidth + FIGURE_MARGIN) +
          FIGURE_MARGIN,
      top + rows * stepY, {"R", "G", "B"});
  std::fill(sheet.pixels.begin(), sheet.pixels.end(), 1.0f);
  drawText(sheet, FIGURE_MARGIN, FIGURE_MARGIN, title, BLACK, FIGURE_TITLE);
  drawText(sheet, FIGURE_MARGIN, FIGURE_MARGIN + TITLE_HEIGHT, subtitle, Rgb(0.2f), FIGURE_TEXT);
  for (const FigurePanel& p : panels) {
    const int x0 = FIGURE_MARGIN + static_cast<int>(std::lround(p.column * static_cast<float>(stepX)));
    const int y0 = top + p.row * stepY;
    const float scale = std::exp2(p.exposure);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < 3; ++c)
          sheet.at(x0 + x, y0 + y)[c] = std::clamp(p.image.rgb(x, y)[c] * scale, 0.0f, 1.0f);
    drawText(sheet, x0, y0 + height + 3, p.name, BLACK, FIGURE_TEXT);
  }
  return sheet;
}

} // namespace recurse
