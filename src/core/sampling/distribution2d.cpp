/** @file
 * Sampling of tabulated densities by inversion of their cumulative sums, which are in double precision so
 * that the rest of the sky still counts beside a sun.
 */
#include "recurse/core/sampling/distribution2d.h"

#include "recurse/core/sampling/linearDensity.h"

namespace recurse {

namespace {

/** Index of the first of the increasing sums above `wanted`; never an entry that adds nothing. */
size_t find(const double* sums, size_t count, double wanted) {
  const double* found = std::upper_bound(sums, sums + count, wanted);
  if (found == sums + count) found = std::lower_bound(sums, sums + count, sums[count - 1]);
  return static_cast<size_t>(found - sums);
}

} // namespace

Distribution2d::Distribution2d(int gridWidth, int gridHeight, const std::vector<double>& corners)
    : width(static_cast<size_t>(gridWidth)), height(static_cast<size_t>(gridHeight)),
      blocks((width + BLOCK - 1) / BLOCK) {
  const double largest = *std::max_element(corners.begin(), corners.end());
  if (!(largest > 0)) return;
  values.reserve(corners.size());
  for (const double c : corners) values.push_back(static_cast<float>(c / largest));
  blockSums.reserve(blocks * height);
  for (size_t y = 0; y < height; ++y) {
    double sum = 0;
    for (size_t x = 0; x < width; ++x) {
      sum += weight(row(y), row(y + 1), x);
      if ((x + 1) % BLOCK == 0 || x + 1 == width) blockSums.push_back(sum);
    }
    rowSums.push_back(total += sum);
  }
}

Distribution2d::Sample Distribution2d::sample(const Vec2d& u) const {
  if (empty()) return {Vec2d(0), 0};
  const double wantedRow = u.y * total;
  const size_t y = find(rowSums.data(), height, wantedRow);
  const double rowsBefore = y > 0 ? rowSums[y - 1] : 0;
  const double v = std::clamp((wantedRow - rowsBefore) / (rowSums[y] - rowsBefore), 0.0, 1.0);

  const double* const sums = &blockSums[y * blocks];
  const float *const above = row(y), *const below = row(y + 1);
  const double wanted = u.x * sums[blocks - 1];
  const size_t block = find(sums, blocks, wanted);
  double rest = wanted - (block > 0 ? sums[block - 1] : 0);
  const size_t end = std::min(width, (block + 1) * BLOCK);
  size_t x = block * BLOCK, last = x;
  double share = 0; // of the chosen cell
  for (; x < end; ++x) {
    const double w = weight(above, below, x);
    if (!(w > 0)) continue;
    last = x;
    share = rest / w;
    if (rest < w) break;
    rest -= w;
  }
  x = last; // the last cell with weight, where rounding has led beyond the end
  share = std::clamp(share, 0.0, 1.0);

  const double a = double(above[x]), b = double(above[x + 1]), c = double(below[x]), d = double(below[x + 1]);
  const double inY = sampleLinear(v, a + b, c + d);
  const double inX = sampleLinear(share, a + (c - a) * inY, b + (d - b) * inY);
  const Vec2d at((double(x) + inX) / double(width), (double(y) + inY) / double(height));
  return {at, pdf(at)};
}

double Distribution2d::pdf(const Vec2d& at) const {
  if (empty()) return 0;
  const double x = std::clamp(at.x, 0.0, 1.0) * double(width),
               y = std::clamp(at.y, 0.0, 1.0) * double(height);
  const size_t column = std::min(static_cast<size_t>(x), width - 1),
               line = std::min(static_cast<size_t>(y), height - 1);
  const double s = x - double(column), t = y - double(line);
  const float *const above = row(line) + column, *const below = row(line + 1) + column;
  const double value = (double(above[0]) * (1 - s) + double(above[1]) * s) * (1 - t) +
                       (double(below[0]) * (1 - s) + double(below[1]) * s) * t;
  return value * 4 * double(width) * double(height) / total;
}

WindowedDistribution2d::WindowedDistribution2d(int gridWidth, int gridHeight,
                                               const std::vector<double>& cells)
    : width(static_cast<size_t>(gridWidth)), height(static_cast<size_t>(gridHeight)) {
  const double largest = *std::max_element(cells.begin(), cells.end());
  if (!(largest > 0)) return;
  sums.assign((width + 1) * (height + 1), 0);
  values.reserve(cells.size());
  for (size_t y = 0; y < height; ++y) {
    double row = 0;
    for (size_t x = 0; x < width; ++x) {
      values.push_back(static_cast<float>(cells[y * width + x] / largest));
      row += double(values.back());
      sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + row;
    }
  }
}

double WindowedDistribution2d::sumTo(double x, double y) const {
  const double px = std::clamp(x, 0.0, 1.0) * double(width), py = std::clamp(y, 0.0, 1.0) * double(height);
  const size_t i = std::min(static_cast<size_t>(px), width - 1),
               k = std::min(static_cast<size_t>(py), height - 1);
  const double s = px - double(i), t = py - double(k);
  const double* const top = &sums[k * (width + 1) + i];
  const double* const bottom = top + width + 1;
  return (top[0] * (1 - s) + top[1] * s) * (1 - t) + (bottom[0] * (1 - s) + bottom[1] * s) * t;
}

double WindowedDistribution2d::sum(const Window& w) const {
  if (values.empty()) return 0;
  const double inside = sumTo(w.high.x, w.high.y) - sumTo(w.low.x, w.high.y) - sumTo(w.high.x, w.low.y) +
                        sumTo(w.low.x, w.low.y);
  // Smaller differences of the sums may be rounding errors alone.
  constexpr double ROUNDING = 1e-12;
  return inside > ROUNDING * sums.back() ? inside : 0;
}

Vec2d WindowedDistribution2d::sample(const Window& w, const Vec2d& u) const {
  // Finds the coordinate in [low, high] at which the cumulative function `upTo` reaches `share` of its total,
  // by bisection over the cells; upTo is linear within cells.
  const auto invert = [](double low, double high, size_t cells, double share, const auto& upTo) {
    const auto n = static_cast<double>(cells);
    const double wanted = share * upTo(high);
    size_t first = std::min(static_cast<size_t>(low * n), cells - 1),
           last = std::min(static_cast<size_t>(high * n), cells - 1);
    while (first < last) {
      const size_t middle = (first + last) / 2;
      if (upTo(std::min(double(middle + 1) / n, high)) > wanted)
        last = middle;
      else
        first = middle + 1;
    }
    const double a = std::max(low, double(first) / n), b = std::min(high, double(first + 1) / n);
    const double before = upTo(a), within = upTo(b) - before;
    return within > 0 ? std::clamp(a + (b - a) * (wanted - before) / within, a, b) : a;
  };
  const double x = invert(w.low.x, w.high.x, width, u.x, [&](double to) {
    return sumTo(to, w.high.y) - sumTo(w.low.x, w.high.y) - sumTo(to, w.low.y) + sumTo(w.low.x, w.low.y);
  });
  const auto n = static_cast<double>(width);
  const double left = std::min(std::floor(x * n), n - 1) / n, right = left + 1 / n; // edges of the column
  const double y = invert(w.low.y, w.high.y, height, u.y, [&](double to) {
    return sumTo(right, to) - sumTo(left, to) - sumTo(right, w.low.y) + sumTo(left, w.low.y);
  });
  return {x, y};
}

double WindowedDistribution2d::pdf(double total, const Vec2d& at) const {
  if (values.empty()) return 0;
  const auto cell = [](double c, size_t cells) {
    return std::min(static_cast<size_t>(std::clamp(c, 0.0, 1.0) * double(cells)), cells - 1);
  };
  const double value = double(values[cell(at.y, height) * width + cell(at.x, width)]);
  return value * double(width) * double(height) / total;
}

} // namespace recurse
