/** @file
 * Drawings of figures: pictures, lines and texts on white paper, as pixels or as SVG.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/core/image/image.h"
#include "recurse/core/math/vector.h"

namespace recurse {

/** Drawing in pixels from the upper left corner. Colours are linear, in [0, 1]. */
struct FigureDrawing {
  struct Picture {
    int x = 0, y = 0; ///< upper left corner; the parts beyond the drawing are cut off
    Image image;      ///< R, G, B
  };
  struct Line {
    std::vector<Vec2f> points;
    Rgb colour = BLACK;
    float width = 1; ///< [pixels]
    bool dashed = false;
  };
  struct Text {
    int x = 0, y = 0; ///< upper left corner
    std::string text; ///< ASCII
    Rgb colour = BLACK;
    int size = 1; ///< pixels of a dot of the bitmap font; a letter is 6 dots wide
  };

  int width = 0, height = 0;
  std::vector<Picture> pictures;
  std::vector<Line> lines; ///< above the pictures
  std::vector<Text> texts; ///< above the lines
};

/** Drawing as an image in linear values, to be written without exposure. */
Image rasterised(const FigureDrawing& drawing);

/** Drawing as an SVG file with the pictures inside. Throws Error. */
std::string svgText(const FigureDrawing& drawing);

/** Throws Error when a drawing could not be written there: see checkImageWritable(); .svg is allowed too. */
void checkDrawingWritable(const std::string& fileName);

/** Writes a drawing as .svg, or in a format of writeImage(). Throws Error. */
void writeDrawing(const std::string& fileName, const FigureDrawing& drawing);

} // namespace recurse
