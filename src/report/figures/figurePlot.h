/** @file
 * Plots of figures.
 */
#pragma once

#include "recurse/report/figures/figures.h"

namespace recurse {

constexpr int MIN_PLOT_WIDTH = 480, PLOT_HEIGHT = 280; ///< [pixels]

/** Draws a plot with its upper left corner at (x, y). */
void drawPlot(FigureDrawing& drawing, const FigurePlot& plot, int x, int y, int width);

} // namespace recurse
