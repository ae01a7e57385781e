/** @file
 * Curves between logarithmic axes.
 */
#include "report/figures/figurePlot.h"

#include <algorithm>
#include <cmath>

#include "recurse/core/io/text.h"
#include "report/page/bitmapFont.h"

namespace recurse {

namespace {

constexpr int LEFT = 60, BOTTOM = 34, ABOVE = 30, LEGEND = 150; ///< around the axes [pixels]
const Rgb GRID{0.8f}, AXIS{0.05f};

/** Map from coordinates to the drawing. */
struct PlotAxes {
  Bounds<Vec2d> decades; ///< logarithms to base 10
  Vec2d origin, size;    ///< lower left corner, and extent upwards and to the right [pixels]

  Vec2f at(const Vec2d& log) const {
    const Vec2d t = (log - decades.lower) / (decades.upper - decades.lower);
    return Vec2f(float(origin.x + t.x * size.x), float(origin.y - t.y * size.y));
  }
};

Vec2d logOf(const Vec2d& p) { return {std::log10(p.x), std::log10(p.y)}; }

/** Range of all curves; the height in whole decades. */
Bounds<Vec2d> decadesOf(const FigurePlot& plot) {
  Bounds<Vec2d> box;
  for (const FigureCurve& curve : plot.curves)
    for (const Vec2d& p : curve.points) {
      if (!(p.x > 0 && p.y > 0)) continue;
      box.lower = glm::min(box.lower, logOf(p));
      box.upper = glm::max(box.upper, logOf(p));
    }
  if (!(box.lower.x <= box.upper.x)) return {Vec2d(0), Vec2d(1)};
  box.lower.y = std::floor(box.lower.y);
  box.upper.y = std::ceil(box.upper.y);
  for (int axis = 0; axis < 2; ++axis)
    if (!(box.lower[axis] < box.upper[axis])) box.upper[axis] = box.lower[axis] + 1;
  return box;
}

void drawAxis(FigureDrawing& drawing, const PlotAxes& axes, int axis) {
  const double low = axes.decades.lower[axis], high = axes.decades.upper[axis];
  const auto mark = [&](double log, bool isLabelled) {
    Vec2d from = axes.decades.lower, to = axes.decades.upper;
    from[axis] = to[axis] = log;
    drawing.lines.push_back({{axes.at(from), axes.at(to)}, GRID, isLabelled ? 1.0f : 0.5f});
    if (!isLabelled) return;
    const std::string text = formatted("%g", std::pow(10, log));
    const Vec2f p = axes.at(from);
    const int width = LETTER_STEP * static_cast<int>(text.size());
    drawing.texts.push_back({static_cast<int>(p.x) - (axis == 0 ? width / 2 : width + 4),
                             static_cast<int>(p.y) + (axis == 0 ? 5 : -4), text, AXIS});
  };
  constexpr double SLACK = 1e-9;
  for (int decade = static_cast<int>(std::floor(low)); decade <= high + SLACK; ++decade)
    for (int digit = 1; digit < 10; ++digit)
      if (const double log = decade + std::log10(digit); log > low - SLACK && log < high + SLACK)
        mark(log, digit == 1);
}

/** Dashed line of the plot's slope, from the upper left end of the curves until it leaves the axes. */
void drawSlope(FigureDrawing& drawing, const FigurePlot& plot, const PlotAxes& axes) {
  Vec2d from(axes.decades.lower.x, -INFINITE_D);
  for (const FigureCurve& curve : plot.curves)
    if (!curve.points.empty() && curve.points.front().y > 0)
      from.y = std::max(from.y, std::log10(curve.points.front().y));
  if (!(from.y > -INFINITE_D)) return;
  const double edge = plot.slope < 0 ? axes.decades.lower.y : axes.decades.upper.y;
  const double length = std::min(axes.decades.upper.x - from.x, (edge - from.y) / plot.slope);
  drawing.lines.push_back(
      {{axes.at(from), axes.at(from + Vec2d(length, plot.slope * length))}, AXIS, 1, true});
}

} // namespace

void drawPlot(FigureDrawing& drawing, const FigurePlot& plot, int x, int y, int width) {
  const int right = x + width - LEGEND, bottom = y + PLOT_HEIGHT - BOTTOM;
  const PlotAxes axes{decadesOf(plot), Vec2d(x + LEFT, bottom), Vec2d(right - x - LEFT, bottom - y - ABOVE)};
  drawing.texts.push_back({x, y, plot.name, BLACK});
  drawing.texts.push_back({x + LEFT, bottom + 20, plot.xName, AXIS});
  drawing.texts.push_back({x, y + ABOVE - LINE_STEP - 6, plot.yName, AXIS});
  for (const int axis : {0, 1}) drawAxis(drawing, axes, axis);
  int row = y + ABOVE;
  const auto legend = [&](const std::string& name, const Rgb& colour, bool dashed) {
    const Vec2f from(static_cast<float>(right + 12), static_cast<float>(row + 4));
    drawing.lines.push_back({{from, from + Vec2f(20, 0)}, colour, dashed ? 1.0f : 2.0f, dashed});
    drawing.texts.push_back({right + 38, row, name, AXIS});
    row += LINE_STEP + 6;
  };
  for (const FigureCurve& curve : plot.curves) {
    std::vector<Vec2f> points;
    for (const Vec2d& p : curve.points)
      if (p.x > 0 && p.y > 0) points.push_back(axes.at(logOf(p)));
    drawing.lines.push_back({points, curve.colour, 2});
    legend(curve.name, curve.colour, false);
  }
  if (plot.slope != 0) {
    drawSlope(drawing, plot, axes);
    legend(formatted("slope %g", plot.slope), AXIS, true);
  }
}

} // namespace recurse
