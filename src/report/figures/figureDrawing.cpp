/** @file
 * Drawings as pixels and as SVG.
 */
#include "recurse/report/figures/figureDrawing.h"

#include <algorithm>
#include <cmath>

#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/text.h"
#include "report/page/bitmapFont.h"
#include "report/page/htmlPage.h"

namespace recurse {

namespace {

constexpr float DASH = 6, DASH_GAP = 4; // [pixels]

/** Distance of a point from a segment. */
float distanceFrom(const Vec2f& p, const Vec2f& a, const Vec2f& b) {
  const Vec2f along = b - a;
  const float length2 = glm::dot(along, along);
  const float t = length2 > 0 ? std::clamp(glm::dot(p - a, along) / length2, 0.0f, 1.0f) : 0;
  return glm::length(p - a - along * t);
}

/** Dashes of a line, each a line of its own. */
std::vector<std::vector<Vec2f>> dashesOf(const std::vector<Vec2f>& points) {
  std::vector<std::vector<Vec2f>> dashes;
  float phase = 0; // on the period of a dash and its gap
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    const Vec2f from = points[i], step = points[i + 1] - from;
    const float length = glm::length(step);
    for (float at = 0; at < length;) {
      const float end = std::min(length, at + (phase < DASH ? DASH : DASH + DASH_GAP) - phase);
      if (phase < DASH) dashes.push_back({from + step * (at / length), from + step * (end / length)});
      phase = std::fmod(phase + end - at, DASH + DASH_GAP);
      at = std::nextafter(end, INFINITE);
    }
  }
  return dashes;
}

/** Draws a line with soft edges. */
void drawLine(Image& image, const std::vector<Vec2f>& points, const Rgb& colour, float width) {
  Bounds<Vec2f> box;
  for (const Vec2f& p : points) {
    box.lower = glm::min(box.lower, p - width);
    box.upper = glm::max(box.upper, p + width);
  }
  const auto within = [](float x, int end) { return std::clamp(static_cast<int>(std::floor(x)), 0, end); };
  for (int y = within(box.lower.y, image.height); y < within(box.upper.y + 1, image.height); ++y)
    for (int x = within(box.lower.x, image.width); x < within(box.upper.x + 1, image.width); ++x) {
      float distance = INFINITE;
      for (size_t i = 0; i + 1 < points.size(); ++i)
        distance = std::min(distance, distanceFrom(Vec2f(x, y) + 0.5f, points[i], points[i + 1]));
      const float opacity = std::clamp(width / 2 + 0.5f - distance, 0.0f, 1.0f);
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] += opacity * (colour[c] - image.at(x, y)[c]);
    }
}

std::string svgColour(const Rgb& colour) {
  std::string text = "#";
  for (int c = 0; c < 3; ++c)
    text += formatted("%02x", static_cast<unsigned>(std::lround(255 * srgbFromLinear(colour[c]))));
  return text;
}

bool isSvg(const std::string& fileName) { return lowerCase(fileName).ends_with(".svg"); }

} // namespace

Image rasterised(const FigureDrawing& drawing) {
  Image sheet(drawing.width, drawing.height, {"R", "G", "B"});
  std::fill(sheet.pixels.begin(), sheet.pixels.end(), 1.0f);
  for (const FigureDrawing::Picture& p : drawing.pictures)
    for (int y = std::max(0, -p.y); y < std::min(p.image.height, sheet.height - p.y); ++y)
      for (int x = std::max(0, -p.x); x < std::min(p.image.width, sheet.width - p.x); ++x)
        for (int c = 0; c < 3; ++c) sheet.at(p.x + x, p.y + y)[c] = p.image.at(x, y)[c];
  for (const FigureDrawing::Line& line : drawing.lines) {
    if (line.dashed)
      for (const auto& dash : dashesOf(line.points)) drawLine(sheet, dash, line.colour, line.width);
    else
      drawLine(sheet, line.points, line.colour, line.width);
  }
  for (const FigureDrawing::Text& t : drawing.texts) drawText(sheet, t.x, t.y, t.text, t.colour, t.size);
  return sheet;
}

std::string svgText(const FigureDrawing& drawing) {
  const std::string size =
      "width=\"" + std::to_string(drawing.width) + "\" height=\"" + std::to_string(drawing.height) + "\"";
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" " + size + " viewBox=\"0 0 " +
                    std::to_string(drawing.width) + " " + std::to_string(drawing.height) + "\">\n<rect " +
                    size + " fill=\"white\"/>\n";
  for (const FigureDrawing::Picture& p : drawing.pictures) {
    Image encoded = p.image;
    for (float& x : encoded.pixels) x = srgbFromLinear(x);
    svg +=
        formatted("<image x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" style=\"image-rendering:pixelated\" ",
                  p.x, p.y, p.image.width, p.image.height) +
        "href=\"data:image/png;base64," + base64(encodedPng(encoded)) + "\"/>\n";
  }
  for (const FigureDrawing::Line& line : drawing.lines) {
    svg += "<polyline fill=\"none\" stroke=\"" + svgColour(line.colour) +
           formatted("\" stroke-width=\"%.3g\"", double(line.width));
    if (line.dashed) svg += formatted(" stroke-dasharray=\"%g %g\"", double(DASH), double(DASH_GAP));
    svg += " points=\"";
    for (const Vec2f& p : line.points) svg += formatted("%.2f,%.2f ", double(p.x), double(p.y));
    svg += "\"/>\n";
  }
  for (const FigureDrawing::Text& t : drawing.texts) {
    constexpr int BASELINE = 7; // [dots] below the upper edge
    svg +=
        formatted("<text x=\"%d\" y=\"%d\" font-family=\"monospace\" font-size=\"%d\" xml:space=\"preserve\" "
                  "textLength=\"%d\" ",
                  t.x, t.y + BASELINE * t.size, 10 * t.size,
                  LETTER_STEP * t.size * static_cast<int>(t.text.size())) +
        "fill=\"" + svgColour(t.colour) + "\">" + escapedHtml(t.text) + "</text>\n";
  }
  return svg + "</svg>\n";
}

void checkDrawingWritable(const std::string& fileName) {
  if (isSvg(fileName))
    checkFileWritable(fileName);
  else
    checkImageWritable(fileName, " .svg");
}

void writeDrawing(const std::string& fileName, const FigureDrawing& drawing) {
  if (isSvg(fileName))
    writeFileAtomically(fileName, svgText(drawing));
  else
    writeImage(fileName, rasterised(drawing));
}

} // namespace recurse
