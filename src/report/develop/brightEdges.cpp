/** @file
 * Antialiasing of edges that are brighter than white. A pixel half covered by a lamp is as white as the lamp
 * after tone mapping, so that a smooth edge becomes a staircase. A correct picture is tone-mapped first and
 * then filtered: the two sides of a pixel are searched in its neighbourhood, and its colour gives the
 * coverage of each. For a lamp too narrow to fill a pixel, the brightest pixel represents its side.
 */
#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "recurse/core/threads/parallel.h"
#include "recurse/report/develop/develop.h"

namespace recurse {

namespace {

struct Offset {
  int x, y;
  int distance2() const { return x * x + y * y; }
};

/** Offsets to pixels no farther away than the root of `radius2`, the nearest first. */
std::vector<Offset> offsetsWithin(int radius2) {
  std::vector<Offset> out;
  for (int y = -radius2; y <= radius2; ++y)
    for (int x = -radius2; x <= radius2; ++x)
      if (x * x + y * y <= radius2) out.push_back({x, y});
  std::stable_sort(out.begin(), out.end(),
                   [](const Offset& a, const Offset& b) { return a.distance2() < b.distance2(); });
  return out;
}

/** Squared reach of an edge [pixels²]: the radius of the widest filter plus half a pixel. */
constexpr int EDGE_REACH2 = 6;
/** Squared distance [pixels²] within which either side of an edge is found: its reach on both sides of it. */
constexpr int SIDE_REACH2 = 25;
/** Least ratio of darkest to brightest of nine pixels that are on one side of an edge. */
constexpr float EVEN = 0.8f;

class BrightEdges {
 public:
  BrightEdges(const Glaring& exposed, const Image& shown)
      : light(exposed.direct), glaring(exposed.light), shown(shown), width(light.width),
        height(light.height) {}

  void mixInto(Image& out) const {
    if (std::none_of(light.pixels.begin(), light.pixels.end(), [](float v) { return v > 1; })) return;
    const std::vector<char> isBright = evenBright();
    parallelFor(size_t(height), [&](size_t row) {
      const int y = int(row);
      for (int x = 0; x < width; ++x) {
        if (isBright[index(x, y)]) continue;
        const auto narrow = narrowLamp(x, y);
        const auto side = narrow ? narrow : evenSide(x, y, isBright);
        if (side) mixPixel(out, x, y, light.rgb(side->x, side->y), shownAt(*side));
      }
    });
  }

 private:
  const Image &light, &glaring, &shown;
  int width, height;

  size_t index(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
  Rgb shownAt(const Offset& p) const { return min(shown.rgb(p.x, p.y), Rgb(1)); }

  /** Pixels that, with all their neighbours, are brighter than white and of similar brightness. */
  std::vector<char> evenBright() const {
    std::vector<char> out(size_t(width) * size_t(height));
    parallelFor(size_t(height), [&](size_t row) {
      for (int x = 0, y = int(row); x < width; ++x) {
        if (brightness(x, y) <= 1) continue;
        const auto [least, most] = range(x, y);
        out[index(x, y)] = least > 1 && least >= EVEN * most;
      }
    });
    return out;
  }
  float brightness(int x, int y) const { return maxComponent(light.rgb(x, y)); }

  template <class Is> std::optional<Offset> nearest(int x, int y, const Is& is) const {
    static const std::vector<Offset> OFFSETS = offsetsWithin(SIDE_REACH2);
    for (const Offset& o : OFFSETS)
      if (isInside(x + o.x, y + o.y) && is(x + o.x, y + o.y)) return Offset{x + o.x, y + o.y};
    return std::nullopt;
  }
  bool isInside(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }

  /** Nearest even pixel of the brighter side: paper around a lamp may be brighter than white, too. */
  std::optional<Offset> evenSide(int x, int y, const std::vector<char>& isBright) const {
    float most = 0;
    const auto isEven = [&](int i, int j) { return isBright[index(i, j)] != 0; };
    nearest(x, y, [&](int i, int j) {
      if (isEven(i, j)) most = std::max(most, brightness(i, j));
      return false;
    });
    if (most == 0) return std::nullopt;
    return nearest(x, y, [&](int i, int j) { return isEven(i, j) && brightness(i, j) > 0.5f * most; });
  }

  /** Brightest pixel around a pixel that is at a bright line. The moments of brightness distinguish lines
   * from noise: lines are long, thin, and filled. */
  std::optional<Offset> narrowLamp(int x, int y) const {
    static const std::vector<Offset> OFFSETS = offsetsWithin(SIDE_REACH2);
    Offset brightest{x, y};
    float near = 0, low = INFINITE; // maximum within the reach of an edge; minimum of all
    for (const Offset& o : OFFSETS) {
      if (!isInside(x + o.x, y + o.y)) continue;
      const float b = brightness(x + o.x, y + o.y);
      if (o.distance2() <= EDGE_REACH2)
        near = std::max(near, b);
      else if (near <= 0.5f)
        return std::nullopt;
      low = std::min(low, b);
      if (b > brightness(brightest.x, brightest.y)) brightest = {x + o.x, y + o.y};
    }
    const float top = brightness(brightest.x, brightest.y);
    if (top <= 1 || near < 0.5f * top || low >= 0.5f * top) return std::nullopt;
    double sum = 0, sx = 0, sy = 0, xx = 0, xy = 0, yy = 0;
    for (const Offset& o : OFFSETS) {
      if (!isInside(x + o.x, y + o.y)) continue;
      const double w = double((brightness(x + o.x, y + o.y) - low) / (top - low));
      sum += w, sx += w * o.x, sy += w * o.y;
      xx += w * o.x * o.x, xy += w * o.x * o.y, yy += w * o.y * o.y;
    }
    // Variances [pixels²] along and across.
    const double a = xx / sum - square(sx / sum), b = xy / sum - sx * sy / square(sum),
                 c = yy / sum - square(sy / sum);
    const double root = std::hypot((a - c) / 2, b), along = (a + c) / 2 + root, across = (a + c) / 2 - root;
    constexpr double LENGTH = 4; // [pixels as bright as the brightest]
    const bool isLine = sum >= LENGTH && across <= 1.5 && along >= 2 * across;
    return isLine ? std::optional(brightest) : std::nullopt;
  }

  /** Whether an edge of this brightness reaches the pixel. */
  bool isReached(int x, int y, float bright) const {
    static const std::vector<Offset> OFFSETS = offsetsWithin(EDGE_REACH2);
    return std::any_of(OFFSETS.begin(), OFFSETS.end(), [&](const Offset& o) {
      return isInside(x + o.x, y + o.y) && brightness(x + o.x, y + o.y) > 0.5f * bright;
    });
  }

  void mixPixel(Image& out, int x, int y, const Rgb& bright, const Rgb& brightShown) const {
    const float top = maxComponent(bright);
    if (!isReached(x, y, top)) return;
    const auto dark = nearest(x, y, [&](int i, int j) { return !isReached(i, j, top); });
    if (!dark) return;
    const Rgb darkLight = light.rgb(dark->x, dark->y);
    const Vec3f contrast(bright - darkLight), above(light.rgb(x, y) - darkLight);
    const float covered = std::clamp(glm::dot(above, contrast) / lengthSquared(contrast), 0.0f, 1.0f);
    const Rgb mixed = covered * brightShown + (1 - covered) * shownAt(withGlareOf(x, y, *dark));
    // The correction fades in with brightness above white.
    const float part = std::min(top - 1, 1.0f);
    // A concave curve shows mixed light brighter than the mixture of shown colours; pixels only darken.
    const Rgb before = shownAt({x, y}), after = before + part * (min(mixed, before) - before);
    std::copy_n(&after.r, 3, out.at(x, y));
  }

  /** Pixel as bright as `dark` would be in the glare at (x, y): the brightest around that is not brighter;
   * `dark` itself where there is no glare. */
  Offset withGlareOf(int x, int y, const Offset& dark) const {
    static const std::vector<Offset> OFFSETS = offsetsWithin(SIDE_REACH2);
    if (glaring.rgb(x, y) == light.rgb(x, y)) return dark;
    // Exact where the lamp covers nothing of the pixel.
    const float most = maxComponent(glaring.rgb(x, y) - (light.rgb(x, y) - light.rgb(dark.x, dark.y)));
    Offset out = dark;
    float best = maxComponent(glaring.rgb(dark.x, dark.y));
    for (const Offset& o : OFFSETS) {
      if (!isInside(x + o.x, y + o.y)) continue;
      const float b = maxComponent(glaring.rgb(x + o.x, y + o.y));
      if (b > best && b <= most) best = b, out = {x + o.x, y + o.y};
    }
    return out;
  }

  /** Range of the brightness of a pixel and its neighbours. */
  std::pair<float, float> range(int x, int y) const {
    float least = INFINITE, most = 0;
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, height - 1); ++j)
      for (int i = std::max(x - 1, 0); i <= std::min(x + 1, width - 1); ++i) {
        least = std::min(least, brightness(i, j));
        most = std::max(most, brightness(i, j));
      }
    return {least, most};
  }
};

} // namespace

void mixBrightEdges(const Glaring& exposed, Image& shown) {
  const Image before = shown;
  BrightEdges(exposed, before).mixInto(shown);
}

} // namespace recurse
