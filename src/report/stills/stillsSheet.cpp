/** @file
 * Contact sheets: pairs of pictures with captions, and the sheet of stills.
 */
#include <algorithm>
#include <cmath>

#include "recurse/core/io/text.h"
#include "recurse/report/stills/stills.h"
#include "report/page/bitmapFont.h"
#include "report/stills/sheet.h"

namespace recurse {

namespace {

constexpr int MARGIN = 16, GAP = 4, PADDING = 8;
constexpr int LARGEST_PICTURE = 320, SMALLEST_PICTURE = 160;
constexpr int TEXT_SIZE = 2, SMALL_SIZE = 1;
constexpr int LINE = LINE_STEP * TEXT_SIZE, SMALL_LINE = LINE_STEP * SMALL_SIZE + 2;
constexpr int EXPRESSION_LINES = 2;
constexpr double WIDTH_TO_HEIGHT = 1.5; ///< preferred aspect ratio of a sheet

// Colours are linear, so that their values are small.
const Rgb BACKGROUND{0.0086f, 0.0091f, 0.0103f}, CELL{0.0185f, 0.0194f, 0.0222f};
const Rgb BRIGHT{0.83f}, DIM{0.36f, 0.38f, 0.42f}, ACCENT{0.9f, 0.52f, 0.13f};

void fill(Image& image, int x, int y, int width, int height, const Rgb& colour) {
  for (int j = y; j < y + height; ++j)
    for (int i = x; i < x + width; ++i)
      for (int c = 0; c < 3; ++c) image.at(i, j)[c] = colour[c];
}

size_t lettersIn(int width, int size) {
  return static_cast<size_t>(std::max(width / (LETTER_STEP * size), 4));
}

std::string cut(const std::string& text, size_t letters) {
  return text.size() <= letters ? text : text.substr(0, letters - 3) + "...";
}

/** Draws a picture reduced by means of pixels, or enlarged by repeating them. Values are clipped as on a
 * display before averaging, so that a dot of light does not spread. */
void drawPicture(Image& sheet, int left, int top, const Image& picture, const SheetLayout& layout,
                 float exposure) {
  const float scale = std::exp2(exposure);
  for (int y = 0; y < layout.pictureHeight; ++y)
    for (int x = 0; x < layout.pictureWidth; ++x) {
      Rgb sum{0};
      int count = 0;
      const int x0 = x / layout.enlarge * layout.shrink, y0 = y / layout.enlarge * layout.shrink;
      for (int j = y0; j < std::min(y0 + layout.shrink, picture.height); ++j)
        for (int i = x0; i < std::min(x0 + layout.shrink, picture.width); ++i, ++count)
          sum += clamp(picture.rgb(i, j) * scale, 0, 1);
      for (int c = 0; c < 3; ++c) sheet.at(left + x, top + y)[c] = sum[c] / static_cast<float>(count);
    }
}

/** Draws a line of text, large where it fits into the width, otherwise small, and finally cut. */
void drawLine(Image& sheet, int left, int top, int width, const std::string& text) {
  const int size = text.size() <= lettersIn(width, TEXT_SIZE) ? TEXT_SIZE : SMALL_SIZE;
  drawText(sheet, left, top, cut(text, lettersIn(width, size)), DIM, size);
}

/** Draws an expression, large where it fits into the lines, otherwise small, and finally cut. */
void drawExpression(Image& sheet, int left, int top, int width, const std::string& expression) {
  const bool large = expression.size() <= EXPRESSION_LINES * lettersIn(width, TEXT_SIZE);
  const int size = large ? TEXT_SIZE : SMALL_SIZE, step = large ? LINE : SMALL_LINE;
  const size_t letters = lettersIn(width, size);
  const int lines = EXPRESSION_LINES * LINE / step;
  std::string rest = expression;
  for (int line = 0; line < lines && !rest.empty(); ++line, top += step) {
    const bool last = line + 1 == lines;
    drawText(sheet, left, top, last ? cut(rest, letters) : rest.substr(0, letters), ACCENT, size);
    rest = rest.size() > letters ? rest.substr(letters) : "";
  }
}

} // namespace

SheetLayout sheetLayout(int pictureWidth, int pictureHeight, size_t layers) {
  SheetLayout s;
  s.margin = MARGIN;
  const int larger = std::max(pictureWidth, pictureHeight);
  if (larger > LARGEST_PICTURE) s.shrink = (larger + LARGEST_PICTURE - 1) / LARGEST_PICTURE;
  if (larger < SMALLEST_PICTURE) s.enlarge = (SMALLEST_PICTURE + larger - 1) / larger;
  s.pictureWidth = (pictureWidth + s.shrink - 1) / s.shrink * s.enlarge;
  s.pictureHeight = (pictureHeight + s.shrink - 1) / s.shrink * s.enlarge;
  s.cellWidth = std::max(2 * s.pictureWidth + GAP, 2 * SMALLEST_PICTURE + GAP) + 2 * PADDING;
  s.cellHeight = s.pictureHeight + 3 * PADDING + (3 + EXPRESSION_LINES) * LINE;
  s.headHeight = MARGIN + 2 * LINE + MARGIN;
  double best = INFINITY;
  for (int columns = 1; columns <= static_cast<int>(layers); ++columns) {
    SheetLayout candidate = s;
    candidate.columns = columns;
    candidate.rows = (static_cast<int>(layers) + columns - 1) / columns;
    const double off =
        std::abs(std::log(double(candidate.width()) / double(candidate.height()) / WIDTH_TO_HEIGHT));
    if (off < best) {
      best = off;
      s.columns = candidate.columns;
      s.rows = candidate.rows;
    }
  }
  return s;
}

Image drawSheet(const std::string& title, const std::string& subtitle, const std::vector<SheetCell>& cells) {
  const Image& first = cells.front().left;
  const SheetLayout s = sheetLayout(first.width, first.height, cells.size());
  Image sheet(s.width(), s.height(), {"R", "G", "B"});
  fill(sheet, 0, 0, sheet.width, sheet.height, BACKGROUND);
  const size_t headLetters = lettersIn(sheet.width - 2 * MARGIN, TEXT_SIZE);
  drawText(sheet, MARGIN, MARGIN, cut(title, headLetters), BRIGHT, TEXT_SIZE);
  drawText(sheet, MARGIN, MARGIN + LINE, cut(subtitle, headLetters), DIM, TEXT_SIZE);
  for (size_t i = 0; i < cells.size(); ++i) {
    const SheetCell& cell = cells[i];
    const int column = static_cast<int>(i) % s.columns, row = static_cast<int>(i) / s.columns;
    const int x = s.margin + column * (s.cellWidth + s.margin);
    const int y = s.headHeight + row * (s.cellHeight + s.margin);
    fill(sheet, x, y, s.cellWidth, s.cellHeight, CELL);
    const int left = x + PADDING, inner = s.cellWidth - 2 * PADDING;
    const int half = (inner - GAP) / 2, right = left + half + GAP;
    int top = y + PADDING;
    drawPicture(sheet, left, top, cell.left, s, cell.leftExposure);
    drawPicture(sheet, right, top, cell.right, s, cell.rightExposure);
    top += s.pictureHeight + PADDING;
    drawLine(sheet, left, top, half - PADDING, cell.leftCaption);
    drawLine(sheet, right, top, half, cell.rightCaption);
    top += LINE;
    const int figureWidth = static_cast<int>(cell.figure.size()) * LETTER_STEP * TEXT_SIZE;
    drawText(sheet, left, top, cut(cell.name, lettersIn(inner - figureWidth - PADDING, TEXT_SIZE)), BRIGHT,
             TEXT_SIZE);
    drawText(sheet, x + s.cellWidth - PADDING - figureWidth, top, cell.figure, BRIGHT, TEXT_SIZE);
    top += LINE;
    drawExpression(sheet, left, top, inner, cell.expression);
    top += EXPRESSION_LINES * LINE;
    drawLine(sheet, left, top, inner, cell.footer);
  }
  return sheet;
}

Image contactSheet(const Stills& stills) {
  std::string way = std::to_string(stills.image.width) + "x" + std::to_string(stills.image.height);
  if (!stills.label.empty()) way += ", " + stills.label;
  if (!stills.additive) way += "; the sum of the classes is not the beauty picture";
  std::vector<SheetCell> cells;
  for (size_t i = 0; i < stills.layers.size(); ++i) {
    const StillLayer& layer = stills.layers[i];
    SheetCell cell;
    cell.left = cell.right = stills.layerImage(i);
    cell.leftExposure = stills.commonExposure();
    cell.rightExposure = layer.exposure;
    cell.leftCaption = formatted("common %+.1f", double(cell.leftExposure));
    cell.rightCaption = formatted("own %+.1f", double(cell.rightExposure));
    cell.name = layer.name;
    cell.figure = formatted("%.2f %%", layer.share * 100);
    cell.expression = layer.expression;
    cell.footer = formatted("mean %.3g", double(layer.mean.r)) + formatted(" %.3g", double(layer.mean.g)) +
                  formatted(" %.3g", double(layer.mean.b));
    cells.push_back(std::move(cell));
  }
  return drawSheet(stills.title, way, cells);
}

} // namespace recurse
