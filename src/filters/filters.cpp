/** @file
 * Pixel filters. All of them are separable, so that each axis is sampled independently.
 */
#include <cmath>

#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** One axis of a filter, tabulated: sampled in proportion to |value|, piecewise constant. */
class TabulatedAxis {
 public:
  template <class F> TabulatedAxis(float radius, const F& value) : radius(radius) {
    double sum = 0, absolute = 0;
    for (int i = 0; i < CELLS; ++i) {
      const double v = value((2 * (i + 0.5) / CELLS - 1) * double(radius));
      negative[size_t(i)] = v < 0;
      sum += v;
      absolute += std::abs(v);
      cumulative[size_t(i)] = absolute;
    }
    for (double& c : cumulative) c /= absolute;
    magnitude = static_cast<float>(absolute / sum);
  }
  Filter::Sample sample(float u) const {
    const auto cell = static_cast<size_t>(
        std::upper_bound(cumulative.begin(), cumulative.end() - 1, double(u)) - cumulative.begin());
    const double below = cell > 0 ? cumulative[cell - 1] : 0;
    const double within = (double(u) - below) / (cumulative[cell] - below);
    const double x = (2 * (double(cell) + std::clamp(within, 0.0, 1.0)) / CELLS - 1) * double(radius);
    return {Vec2f(static_cast<float>(x), 0), negative[cell] ? -magnitude : magnitude};
  }
  float value(float x) const {
    const float place = (x / radius + 1) * (0.5f * CELLS);
    if (!(place >= 0 && place < CELLS)) return 0;
    const auto cell = static_cast<size_t>(place);
    const double part = cumulative[cell] - (cell > 0 ? cumulative[cell - 1] : 0);
    const float density = static_cast<float>(part) * (0.5f * CELLS) / radius;
    return negative[cell] ? -magnitude * density : magnitude * density;
  }
  const float radius;

 private:
  static constexpr int CELLS = 512;
  float magnitude = 1;
  std::array<double, CELLS> cumulative{};
  std::array<bool, CELLS> negative{};
};

class TabulatedFilter final : public Filter {
 public:
  TabulatedFilter(const TabulatedAxis& x, const TabulatedAxis& y) : x(x), y(y) {}
  Sample sample(const Vec2f& u) const override {
    const Sample a = x.sample(u.x), b = y.sample(u.y);
    return {{a.offset.x, b.offset.x}, a.weight * b.weight};
  }
  float value(const Vec2f& offset) const override { return x.value(offset.x) * y.value(offset.y); }
  Vec2f radius() const override { return {x.radius, y.radius}; }

 private:
  TabulatedAxis x, y;
};

class Box final : public Filter {
 public:
  explicit Box(const Vec2f& radius) : half(radius) {}
  Sample sample(const Vec2f& u) const override { return {(u * 2.0f - 1.0f) * half, 1}; }
  float value(const Vec2f& offset) const override {
    // A border between two pixels belongs to one of them.
    const bool inside = offset.x >= -half.x && offset.x < half.x && offset.y >= -half.y && offset.y < half.y;
    return inside ? 1 / (4 * half.x * half.y) : 0;
  }
  Vec2f radius() const override { return half; }

 private:
  Vec2f half;
};

class Triangle final : public Filter {
 public:
  explicit Triangle(const Vec2f& radius) : half(radius) {}
  Sample sample(const Vec2f& u) const override { return {Vec2f(tent(u.x), tent(u.y)) * half, 1}; }
  float value(const Vec2f& offset) const override {
    const Vec2f height = glm::max(1.0f - glm::abs(offset) / half, 0.0f) / half;
    return height.x * height.y;
  }
  Vec2f radius() const override { return half; }

 private:
  static float tent(float u) { return u < 0.5f ? std::sqrt(2 * u) - 1 : 1 - std::sqrt(2 * (1 - u)); }
  Vec2f half;
};

std::vector<ParameterSpec> radiusParameters(const std::string& radius, std::vector<ParameterSpec> more = {}) {
  more.insert(more.begin(), {realParameter("xradius", radius, "half width [pixels]").range(0.01, 100),
                             realParameter("yradius", radius, "half height [pixels]").range(0.01, 100)});
  return more;
}

Vec2f radiusOf(const Parameters& p) { return {p.real("xradius"), p.real("yradius")}; }

/** D. P. Mitchell and A. N. Netravali, "Reconstruction Filters in Computer Graphics", 1988, equation 8. */
double mitchell(double x, double b, double c) {
  x = std::abs(2 * x);
  if (x > 2) return 0;
  if (x > 1)
    return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) /
           6;
  return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) / 6;
}

double sinc(double x) { return x == 0 ? 1 : std::sin(double(PI) * x) / (double(PI) * x); }

} // namespace

void registerFilters(PlugIns& plugIns) {
  auto& filters = plugIns.filters;
  filters.add({{.name = "box",
                .summary = "Constant weight.",
                .parameters = radiusParameters("0.5"),
                .examples = {""}},
               [](const Parameters& p, const NoContext&) { return std::make_unique<Box>(radiusOf(p)); }});
  filters.add(
      {{.name = "triangle",
        .summary = "Weight decreases linearly along each axis.",
        .parameters = radiusParameters("2"),
        .examples = {""}},
       [](const Parameters& p, const NoContext&) { return std::make_unique<Triangle>(radiusOf(p)); }});
  filters.add({{.name = "gaussian",
                .summary = "A Gaussian, shifted down so that it ends at zero.",
                .parameters = radiusParameters(
                    "1.5", {realParameter("sigma", "0.5", "standard deviation [pixels]").range(0.01, 1e4)}),
                .examples = {""}},
               [](const Parameters& p, const NoContext&) {
                 const double sigma = p.real("sigma");
                 const auto axis = [&](float radius) {
                   const auto g = [&](double x) { return std::exp(-x * x / (2 * sigma * sigma)); };
                   return TabulatedAxis(radius, [&](double x) { return g(x) - g(double(radius)); });
                 };
                 const Vec2f r = radiusOf(p);
                 return std::make_unique<TabulatedFilter>(axis(r.x), axis(r.y));
               }});
  filters.add(
      {{.name = "mitchell",
        .summary = "Mitchell and Netravali's cubic with negative lobes: sharp, little ringing.",
        .parameters = radiusParameters("2", {realParameter("B", "0.333333333333", "blur").range(0, 1),
                                             realParameter("C", "0.333333333333", "ringing").range(0, 1)}),
        .examples = {""}},
       [](const Parameters& p, const NoContext&) {
         const auto axis = [&](float radius) {
           return TabulatedAxis(
               radius, [&](double x) { return mitchell(x / double(radius), p.real("B"), p.real("C")); });
         };
         const Vec2f r = radiusOf(p);
         return std::make_unique<TabulatedFilter>(axis(r.x), axis(r.y));
       }});
  filters.add(
      {{.name = "sinc",
        .summary = "Windowed sinc (Lanczos): sharp, with more ringing.",
        .parameters = radiusParameters(
            "4",
            {realParameter("tau", "3", "cycles of the sinc function within the window").range(0.01, 100)}),
        .examples = {""}},
       [](const Parameters& p, const NoContext&) {
         const auto axis = [&](float radius) {
           // C. Duchon, "Lanczos Filtering in One and Two Dimensions", 1979, with pbrt's parameters.
           return TabulatedAxis(radius, [&](double x) { return sinc(x) * sinc(x / p.real("tau")); });
         };
         const Vec2f r = radiusOf(p);
         return std::make_unique<TabulatedFilter>(axis(r.x), axis(r.y));
       }});
}

} // namespace recurse
