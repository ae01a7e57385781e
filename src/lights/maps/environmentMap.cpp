/** @file
 * Lookup, integrals and densities of pictures of all directions.
 */
#include "lights/maps/environmentMap.h"

#include <functional>
#include <numbers>
#include <numeric>

#include "recurse/core/sampling/equalAreaSquare.h"
#include "recurse/core/threads/parallel.h"

namespace recurse {

namespace {

using std::numbers::pi;
/** Limit on table cells. Below it cells are half as wide as pixels, so that the interpolation is bilinear
 * on each; above it they are whole pixels. */
constexpr size_t MAX_FINE_CELLS = size_t(1) << 24;

/** Jacobian of the mapping [sr per unit area of the square]. */
double solidAngle(EnvironmentMapping mapping, double y) {
  return mapping == EnvironmentMapping::EQUAL_AREA ? 4 * pi : 2 * square(pi) * std::sin(pi * y);
}

/** ∫ of the interpolation weight of row `row` of `height`, times sin θ, over θ / π. */
double rowWeight(int row, int height) {
  const double h = 1.0 / height, centre = (row + 0.5) * h;
  // Three-point Gauss quadrature on each half, where the weight falls linearly towards the centre of the
  // neighbour, or is 1 up to the pole.
  double sum = 0;
  for (const int side : {-1, 1}) {
    const bool last = side < 0 ? row == 0 : row == height - 1;
    const double length = last ? h / 2 : h;
    constexpr double NODES[] = {0.1127016653792583, 0.5, 0.8872983346207417}, WEIGHTS[] = {5, 8, 5};
    for (int i = 0; i < 3; ++i)
      sum += WEIGHTS[i] / 18 * length * (last ? 1 : 1 - NODES[i]) *
             std::sin(pi * (centre + side * NODES[i] * length));
  }
  return sum;
}

} // namespace

Vec2d placeOfDirection(EnvironmentMapping mapping, const Vec3d& d) {
  const double azimuth = std::atan2(d.y, d.x);
  if (mapping == EnvironmentMapping::LATITUDE_LONGITUDE)
    return {azimuth / (2 * pi) + (azimuth < 0 ? 1 : 0), std::atan2(std::hypot(d.x, d.y), d.z) / pi};
  return squareOfDirection(d);
}

Vec3d directionOfPlace(EnvironmentMapping mapping, const Vec2d& place) {
  if (mapping == EnvironmentMapping::LATITUDE_LONGITUDE) {
    const double phi = 2 * pi * place.x, theta = pi * place.y, s = std::sin(theta);
    return {s * std::cos(phi), s * std::sin(phi), std::cos(theta)};
  }
  return directionOfSquare(place);
}

EnvironmentMap::EnvironmentMap(const Image& picture, EnvironmentMapping mapping)
    : mapping(mapping), width(picture.width), height(picture.height) {
  pixels.reserve(size_t(width) * size_t(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) pixels.push_back(picture.rgb(x, y));
  integrate();
  tabulate();
}

const Rgb& EnvironmentMap::pixel(int x, int y) const {
  if (mapping == EnvironmentMapping::LATITUDE_LONGITUDE) {
    if (y < 0 || y >= height) { // over the pole
      x += width / 2;
      y = y < 0 ? 0 : height - 1;
    }
    x = x < 0 ? x + width : x >= width ? x - width : x;
  } else {
    if (x < 0 || x >= width) {
      x = x < 0 ? 0 : width - 1;
      y = height - 1 - y;
    }
    if (y < 0 || y >= height) {
      y = y < 0 ? 0 : height - 1;
      x = width - 1 - x;
    }
  }
  return pixels[size_t(y) * size_t(width) + size_t(x)];
}

Rgb EnvironmentMap::at(const Vec2d& place) const {
  const double x = place.x * width - 0.5, y = place.y * height - 0.5;
  const double left = std::floor(x), top = std::floor(y);
  const auto s = static_cast<float>(x - left), t = static_cast<float>(y - top);
  const int i = static_cast<int>(left), k = static_cast<int>(top);
  return (pixel(i, k) * (1 - s) + pixel(i + 1, k) * s) * (1 - t) +
         (pixel(i, k + 1) * (1 - s) + pixel(i + 1, k + 1) * s) * t;
}

void EnvironmentMap::integrate() {
  for (int y = 0; y < height; ++y) {
    Rgbd row(0);
    for (int x = 0; x < width; ++x) row += Rgbd(pixels[size_t(y) * size_t(width) + size_t(x)]);
    wholeIntegral +=
        row / double(width) *
        (mapping == EnvironmentMapping::EQUAL_AREA ? 4 * pi / height : 2 * square(pi) * rowWeight(y, height));
  }
}

void EnvironmentMap::tabulate() {
  const int part = size_t(4) * pixels.size() <= MAX_FINE_CELLS ? 2 : 1;
  const int columns = part * width, rows = part * height;
  const double mean = double(luminance(Rgb(wholeIntegral))) / (4 * pi);
  std::vector<double> corners(size_t(columns + 1) * size_t(rows + 1));
  std::vector<double> brighter(corners.size()); // MIS-compensated integrand
  parallelFor(size_t(rows) + 1, [&](size_t y) {
    const double v = double(y) / rows, stretch = solidAngle(mapping, v);
    for (size_t x = 0; x <= size_t(columns); ++x) {
      const double l = double(luminance(at({double(x) / columns, v})));
      const size_t i = y * size_t(columns + 1) + x;
      corners[i] = std::max(0.0, l * stretch);
      // With equal sample counts and one uniform technique, the best second technique samples the remainder
      // of twice the integrand.
      brighter[i] = std::max(0.0, (l - mean / 2) * stretch);
    }
  });
  complete = Distribution2d(columns, rows, corners);
  const auto leavesOut = [](double all, double some) { return all > 0 && some == 0; };
  if (std::inner_product(corners.begin(), corners.end(), brighter.begin(), false, std::logical_or<>(),
                         leavesOut))
    compensated = Distribution2d(columns, rows, brighter);
}

EnvironmentMap::Sample EnvironmentMap::sample(const Vec2f& u, Sampling sampling) const {
  const Distribution2d::Sample s = densities(sampling).sample(Vec2d(u));
  const double stretch = solidAngle(mapping, s.at.y);
  return {directionOfPlace(mapping, s.at), stretch > 0 ? s.pdf / stretch : 0};
}

double EnvironmentMap::pdf(const Vec3d& direction, Sampling sampling) const {
  const Vec2d place = placeOfDirection(mapping, direction);
  const double stretch = solidAngle(mapping, place.y);
  return stretch > 0 ? densities(sampling).pdf(place) / stretch : 0;
}

double EnvironmentMap::upperIrradiance() const {
  constexpr int SUB = 2; // subsamples per texel side; the horizon crosses texels
  double sum = 0;
  const int columns = SUB * width, rows = SUB * height;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const Vec2d place((x + 0.5) / columns, (y + 0.5) / rows);
      const double cosine = directionOfPlace(mapping, place).z;
      if (cosine > 0) sum += double(luminance(at(place))) * cosine * solidAngle(mapping, place.y);
    }
  return sum / (double(columns) * rows);
}

} // namespace recurse
