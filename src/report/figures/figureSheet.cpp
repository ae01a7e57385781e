/** @file
 * Layout of figures.
 */
#include <algorithm>
#include <cmath>

#include "recurse/core/io/text.h"
#include "recurse/report/figures/figures.h"
#include "report/compare/falseColour.h"
#include "report/figures/figurePlot.h"
#include "report/page/bitmapFont.h"

namespace recurse {

namespace {

constexpr int FIGURE_MARGIN = 12, FIGURE_TEXT = 1, FIGURE_TITLE = 2;
constexpr int NAME_HEIGHT = LINE_STEP * FIGURE_TEXT + 4, TITLE_HEIGHT = LINE_STEP * FIGURE_TITLE + 4;
constexpr int SCALE_HEIGHT = 8; ///< of the bar of a colour scale; its numbers have a line of their own

int textWidth(const std::string& text, int size) {
  return LETTER_STEP * size * static_cast<int>(text.size());
}

Image exposed(const FigurePanel& panel) {
  Image image = panel.image;
  for (float& x : image.pixels) x = std::clamp(x * std::exp2(panel.exposure), 0.0f, 1.0f);
  return image;
}

std::string scaleText(const ColourScale& scale) {
  return formatted("%.3g to %.3g ", scale.low, scale.high) + scale.unit +
         (scale.isLogarithmic ? ", logarithmic" : "");
}

Image scaleBar(const ColourScale& scale, int width) {
  Image bar(width, SCALE_HEIGHT, {"R", "G", "B"});
  for (int x = 0; x < width; ++x) {
    const Rgb colour = scale.colour(scale.valueAt((double(x) + 0.5) / double(width)));
    for (int y = 0; y < SCALE_HEIGHT; ++y)
      for (int c = 0; c < 3; ++c) bar.at(x, y)[c] = colour[c];
  }
  return bar;
}

/** Grid of the panels. */
struct FigureGrid {
  float columns = 0;
  int rows = 0, stepX = 0, stepY = 0;

  explicit FigureGrid(const std::vector<FigurePanel>& panels) {
    bool hasScale = false;
    for (const FigurePanel& p : panels) {
      columns = std::max(columns, p.column + 1);
      rows = std::max(rows, p.row + 1);
      hasScale = hasScale || p.scale;
      const int text =
          std::max(textWidth(p.name, FIGURE_TEXT), p.scale ? textWidth(scaleText(*p.scale), FIGURE_TEXT) : 0);
      stepX = std::max({stepX, p.image.width, text});
      stepY = std::max(stepY, p.image.height);
    }
    stepX += FIGURE_MARGIN;
    stepY += NAME_HEIGHT + FIGURE_MARGIN + (hasScale ? SCALE_HEIGHT + NAME_HEIGHT : 0);
  }
};

void drawPanel(FigureDrawing& drawing, const FigurePanel& panel, int x, int y) {
  drawing.pictures.push_back({x, y, exposed(panel)});
  y += panel.image.height + 3;
  drawing.texts.push_back({x, y, panel.name, BLACK, FIGURE_TEXT});
  if (!panel.scale) return;
  drawing.pictures.push_back({x, y + NAME_HEIGHT - 1, scaleBar(*panel.scale, panel.image.width)});
  drawing.texts.push_back(
      {x, y + NAME_HEIGHT + SCALE_HEIGHT + 2, scaleText(*panel.scale), Rgb(0.1f), FIGURE_TEXT});
}

} // namespace

double ColourScale::valueAt(double position) const {
  return isLogarithmic ? low * std::pow(high / low, position) : low + (high - low) * position;
}

Rgb ColourScale::colour(double value) const {
  double t = diverging ? 0.5 : 0; // position on a scale without extent
  if (isLogarithmic && high > low)
    t = value > low ? std::min(std::log(value / low) / std::log(high / low), 1.0) : 0.0;
  else if (high > low)
    t = std::clamp((value - low) / (high - low), 0.0, 1.0);
  return diverging ? divergingColour(static_cast<float>(2 * t - 1)) : falseColour(static_cast<float>(t));
}

FigurePanel scaledPanel(const PixelBounds& crop, const std::vector<double>& values, const ColourScale& scale,
                        const std::string& name, int row, float column) {
  FigurePanel panel{Image(crop.width(), crop.height(), {"R", "G", "B"}), name, row, column, 0, scale};
  for (size_t i = 0; i < values.size(); ++i) {
    const Rgb colour = std::isfinite(values[i]) ? scale.colour(values[i]) : BLACK;
    for (size_t c = 0; c < 3; ++c) panel.image.pixels[3 * i + c] = colour[int(c)];
  }
  return panel;
}

double quantileOf(std::vector<double> values, double fraction) {
  const auto at = values.begin() + std::ptrdiff_t(fraction * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

FigureDrawing figureSheet(const std::string& title, const std::string& subtitle,
                          const std::vector<FigurePanel>& panels, const FigurePlot* plot) {
  const FigureGrid grid(panels);
  const int top = FIGURE_MARGIN + TITLE_HEIGHT + NAME_HEIGHT;
  FigureDrawing drawing;
  drawing.width =
      FIGURE_MARGIN +
      std::max({static_cast<int>(std::ceil(grid.columns * static_cast<float>(grid.stepX))),
                textWidth(title, FIGURE_TITLE) + FIGURE_MARGIN,
                textWidth(subtitle, FIGURE_TEXT) + FIGURE_MARGIN, plot ? MIN_PLOT_WIDTH + FIGURE_MARGIN : 0});
  drawing.height = top + grid.rows * grid.stepY;
  drawing.texts.push_back({FIGURE_MARGIN, FIGURE_MARGIN, title, BLACK, FIGURE_TITLE});
  drawing.texts.push_back({FIGURE_MARGIN, FIGURE_MARGIN + TITLE_HEIGHT, subtitle, Rgb(0.2f), FIGURE_TEXT});
  for (const FigurePanel& p : panels)
    drawPanel(drawing, p,
              FIGURE_MARGIN + static_cast<int>(std::lround(p.column * static_cast<float>(grid.stepX))),
              top + p.row * grid.stepY);
  if (plot) {
    drawPlot(drawing, *plot, FIGURE_MARGIN, drawing.height, drawing.width - 2 * FIGURE_MARGIN);
    drawing.height += PLOT_HEIGHT + FIGURE_MARGIN;
  }
  return drawing;
}

} // namespace recurse
