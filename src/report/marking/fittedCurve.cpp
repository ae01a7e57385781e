/** @file
 * Fit of a tone curve. Cells are sorted by one half of a checkerboard of the reference and divided into
 * groups. The means of a group over the other half are a knot, so that neither noise of the reference nor
 * bright pixels of the picture bend the curve. Groups are smaller at both ends, like the distances of
 * Chebyshev's nodes, because the curve is extrapolated there.
 */
#include "report/marking/fittedCurve.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recurse {

namespace {

/** Slopes of a curve in logarithms: a flatter one has no inverse, a steeper one than the power 2.4 of sRGB's
 * curve would make light black. */
constexpr double LEAST_SLOPE = 0.02, MOST_SLOPE = 2.4;

struct Pair {
  double key = 0;              ///< light of the black pixels of a cell
  double light = 0, value = 0; ///< of the white pixels
};

/** Cells of a picture that can be used, of each channel or of the luminance. */
std::vector<Pair> pairsOf(const Image& picture, const Image& light, CurveDomain domain, int side) {
  std::vector<Pair> out;
  for (int top = 0; top + side <= picture.height; top += side)
    for (int left = 0; left + side <= picture.width; left += side) {
      Rgb value(0), halves[2] = {Rgb(0), Rgb(0)};
      for (int y = top; y < top + side; ++y)
        for (int x = left; x < left + side; ++x) {
          const int half = (x + y) % 2;
          if (half == 1) value += picture.rgb(x, y);
          halves[half] += light.rgb(x, y);
        }
      if (!isFinite(value) || !isFinite(halves[0] + halves[1])) continue;
      if (domain == CurveDomain::LUMINANCE)
        out.push_back({double(luminance(halves[0])), double(luminance(halves[1])), double(luminance(value))});
      else
        for (int c = 0; c < 3; ++c)
          out.push_back({double(halves[0][c]), double(halves[1][c]), double(value[c])});
    }
  const double pixels = side * side / 2;
  for (Pair& pair : out) pair = {pair.key, pair.light / pixels, pair.value / pixels};
  std::sort(out.begin(), out.end(), [](const Pair& a, const Pair& b) { return a.key < b.key; });
  return out;
}

/** Monotone cubic interpolation of `y` by `x` between knots (Fritsch and Butland 1984); straight beyond them.
 */
template <class Knot>
double interpolated(const std::vector<Knot>& knots, double Knot::*x, double Knot::*y, double at) {
  const auto secant = [&](size_t k) {
    return (knots[k + 1].*y - knots[k].*y) / (knots[k + 1].*x - knots[k].*x);
  };
  const auto slope = [&](size_t k) {
    if (k == 0) return secant(0);
    if (k + 1 == knots.size()) return secant(k - 1);
    return 2 / (1 / secant(k - 1) + 1 / secant(k));
  };
  const size_t last = knots.size() - 1;
  if (at <= knots[0].*x) return knots[0].*y + slope(0) * (at - knots[0].*x);
  if (at >= knots[last].*x) return knots[last].*y + slope(last) * (at - knots[last].*x);
  size_t k = 0;
  while (knots[k + 1].*x < at) ++k;
  const double width = knots[k + 1].*x - knots[k].*x, t = (at - knots[k].*x) / width, u = 1 - t;
  return knots[k].*y * u * u * (1 + 2 * t) + knots[k + 1].*y * t * t * (1 + 2 * u) +
         width * t * u * (slope(k) * u - slope(k + 1) * t);
}

} // namespace

FittedCurve::FittedCurve(const Image& picture, const Image& light, CurveDomain domain, int side)
    : domain(domain) {
  const std::vector<Pair> pairs = pairsOf(picture, light, domain, side);
  size_t start = 0;
  for (size_t k = 1; k <= KNOTS; ++k) {
    const double part = (1 - std::cos(std::numbers::pi * double(k) / KNOTS)) / 2;
    const size_t end = static_cast<size_t>(std::lround(part * double(pairs.size())));
    const double count = double(end - start);
    double lights = 0, values = 0;
    for (; start < end; ++start) {
      lights += pairs[start].light;
      values += pairs[start].value;
    }
    if (!(lights > 0)) continue;
    if (!(values > 0)) { // light that is black is missing
      knots.clear();
      return;
    }
    Knot knot{std::log(lights / count), std::log(values / count)};
    if (!knots.empty()) {
      const double width = knot.light - knots.back().light;
      if (width <= 0) continue;
      knot.value = std::clamp(knot.value, knots.back().value + LEAST_SLOPE * width,
                              knots.back().value + MOST_SLOPE * width);
    }
    knots.push_back(knot);
  }
  if (knots.size() < 2) knots.clear();
}

template <class Curve> Image FittedCurve::mapped(const Image& image, const Curve& curve) const {
  Image out(image.width, image.height, {"R", "G", "B"});
  const auto at = [&](float x) {
    return x > 0 ? static_cast<float>(std::exp(curve(std::log(double(x))))) : x;
  };
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Rgb colour = image.rgb(x, y);
      const float light = luminance(colour);
      for (int c = 0; c < 3; ++c)
        out.at(x, y)[c] = domain == CurveDomain::CHANNELS ? at(colour[c])
                          : light > 0                     ? colour[c] * (at(light) / light)
                                                          : colour[c];
    }
  return out;
}

Image FittedCurve::shown(const Image& light) const {
  return mapped(light, [&](double x) { return interpolated(knots, &Knot::light, &Knot::value, x); });
}

Image FittedCurve::light(const Image& picture) const {
  return mapped(picture, [&](double x) { return interpolated(knots, &Knot::value, &Knot::light, x); });
}

} // namespace recurse
