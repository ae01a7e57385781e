/** @file
 * Fit of a tone curve. Cells are sorted by the sum of their ranks in the picture and in the reference,
 * neither of which is free of noise, and divided into groups. The medians of a group are a knot. Groups are
 * smaller at both ends, like the distances of Chebyshev's nodes, because the curve is extrapolated there.
 */
#include "report/marking/fittedCurve.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace recurse {

namespace {

/** Least slope of a curve in logarithms: a flatter one has no inverse. */
constexpr double LEAST_SLOPE = 0.02;

struct Pair {
  double light, value;
};

/** Logarithms of the means over squares of pixels where both are positive. */
std::vector<Pair> pairsOf(const Image& picture, const Image& light, CurveDomain domain, int side) {
  std::vector<Pair> out;
  for (int top = 0; top + side <= picture.height; top += side)
    for (int left = 0; left + side <= picture.width; left += side) {
      Rgb value(0), mean(0);
      for (int y = top; y < top + side; ++y)
        for (int x = left; x < left + side; ++x) {
          value += picture.rgb(x, y);
          mean += light.rgb(x, y);
        }
      const auto add = [&](double of, double shown) {
        const double pixels = double(side) * side;
        if (of > 0 && shown > 0 && std::isfinite(of) && std::isfinite(shown))
          out.push_back({std::log(of / pixels), std::log(shown / pixels)});
      };
      if (domain == CurveDomain::LUMINANCE) add(double(luminance(mean)), double(luminance(value)));
      if (domain == CurveDomain::CHANNELS)
        for (int c = 0; c < 3; ++c) add(double(mean[c]), double(value[c]));
    }
  return out;
}

template <class Key> std::vector<size_t> sortedBy(size_t count, const Key& key) {
  std::vector<size_t> order(count);
  std::iota(order.begin(), order.end(), size_t(0));
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return key(a) < key(b); });
  return order;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/** Linear interpolation of `y` by `x` between knots; the last segment continues, and the first has slope 1.
 */
template <class Knot>
double interpolated(const std::vector<Knot>& knots, double Knot::*x, double Knot::*y, double at) {
  if (at <= knots.front().*x) return knots.front().*y + at - knots.front().*x;
  size_t next = 1;
  while (next + 1 < knots.size() && knots[next].*x < at) ++next;
  const Knot &a = knots[next - 1], &b = knots[next];
  return a.*y + (b.*y - a.*y) * (at - a.*x) / (b.*x - a.*x);
}

} // namespace

FittedCurve::FittedCurve(const Image& picture, const Image& light, CurveDomain domain, int side)
    : domain(domain) {
  const std::vector<Pair> pairs = pairsOf(picture, light, domain, side);
  std::vector<size_t> rank(pairs.size());
  for (double Pair::*coordinate : {&Pair::light, &Pair::value}) {
    const auto order = sortedBy(pairs.size(), [&](size_t i) { return pairs[i].*coordinate; });
    for (size_t i = 0; i < order.size(); ++i) rank[order[i]] += i;
  }
  const std::vector<size_t> order = sortedBy(pairs.size(), [&](size_t i) { return rank[i]; });
  size_t start = 0;
  for (size_t k = 1; k <= KNOTS; ++k) {
    const double part = (1 - std::cos(std::numbers::pi * double(k) / KNOTS)) / 2;
    const size_t end = static_cast<size_t>(std::lround(part * double(order.size())));
    std::vector<double> lights, values;
    for (size_t i = start; i < end; ++i) {
      lights.push_back(pairs[order[i]].light);
      values.push_back(pairs[order[i]].value);
    }
    start = end;
    if (lights.empty()) continue;
    Knot knot{median(lights), median(values)};
    if (!knots.empty()) {
      if (knot.light <= knots.back().light) continue;
      knot.value = std::max(knot.value, knots.back().value + LEAST_SLOPE * (knot.light - knots.back().light));
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
