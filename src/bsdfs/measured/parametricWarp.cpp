/** @file
 * Inversion of piecewise linear densities that are blended from slices. Their integrals are blended with the
 * same weights.
 */
#include "bsdfs/measured/parametricWarp.h"

#include "recurse/core/sampling/linearDensity.h"

namespace recurse {

namespace {

struct Bracket {
  uint32_t below, above;
  float t; ///< weight of the node above
};
Bracket bracket(const std::vector<float>& nodes, float x) {
  const auto next = static_cast<uint32_t>(std::upper_bound(nodes.begin(), nodes.end(), x) - nodes.begin());
  if (next == 0) return {0, 0, 0};
  if (next == nodes.size()) return {next - 1, next - 1, 0};
  return {next - 1, next, (x - nodes[next - 1]) / (nodes[next] - nodes[next - 1])};
}

/** Cell in which the rising sums at `nodes` nodes pass `wanted`; its own increment is above 0. */
template <class F> size_t findCell(size_t nodes, double wanted, const F& sum) {
  size_t low = 0, high = nodes - 1; // sum(low) <= wanted < sum(high)
  while (high - low > 1) {
    const size_t middle = (low + high) / 2;
    (sum(middle) <= wanted ? low : high) = middle;
  }
  return low;
}

double lerp(double a, double b, double t) { return a + (b - a) * t; }

/** Integral from 0 to t of the linear function that is a at 0 and b at 1. */
double linearIntegral(double a, double b, double t) { return t * (a + 0.5 * (b - a) * t); }

/** Upper bound t for which linearIntegral(a, b, t) is `wanted`. */
double invertLinear(double wanted, double a, double b) {
  return a + b > 0 ? sampleLinear(std::clamp(2 * wanted / (a + b), 0.0, 1.0), a, b) : 0;
}

} // namespace

SliceBlend ParameterGrid::at(float a, float b) const {
  const Bracket f = bracket(first, a), s = bracket(second, b);
  SliceBlend blend;
  const auto add = [&](uint32_t i, uint32_t j, float weight) {
    if (!(weight > 0)) return;
    blend.slices[blend.count] = i * static_cast<uint32_t>(second.size()) + j;
    blend.weights[blend.count++] = weight;
  };
  add(f.below, s.below, (1 - f.t) * (1 - s.t));
  add(f.below, s.above, (1 - f.t) * s.t);
  add(f.above, s.below, f.t * (1 - s.t));
  add(f.above, s.above, f.t * s.t);
  return blend;
}

ParametricWarp::ParametricWarp(size_t columns, size_t rows, std::vector<float> tables)
    : columns(columns), rows(rows), values(std::move(tables)) {
  const size_t slices = values.size() / (columns * rows);
  alongRows.resize(values.size());
  rowSums.resize(slices * rows);
  for (size_t s = 0; s < slices; ++s) normalize(s);
}

void ParametricWarp::normalize(size_t slice) {
  float* const v = &values[slice * columns * rows];
  if (std::all_of(v, v + columns * rows, [](float x) { return !(x > 0); }))
    std::fill_n(v, columns * rows, 1.0f);
  std::vector<double> along(columns * rows), sums(rows);
  for (size_t y = 0; y < rows; ++y)
    for (size_t x = 1; x < columns; ++x) {
      const size_t i = y * columns + x;
      along[i] = along[i - 1] + 0.5 * (double(v[i - 1]) + double(v[i])) / double(columns - 1);
    }
  const auto whole = [&](size_t y) { return along[(y + 1) * columns - 1]; };
  for (size_t y = 1; y < rows; ++y)
    sums[y] = sums[y - 1] + 0.5 * (whole(y - 1) + whole(y)) / double(rows - 1);
  const double total = sums[rows - 1];
  for (size_t i = 0; i < columns * rows; ++i) {
    v[i] = static_cast<float>(double(v[i]) / total);
    alongRows[slice * columns * rows + i] = static_cast<float>(along[i] / total);
  }
  for (size_t y = 0; y < rows; ++y) rowSums[slice * rows + y] = static_cast<float>(sums[y] / total);
}

ParametricWarp::Point ParametricWarp::sample(const SliceBlend& blend, const Vec2d& u) const {
  const size_t stride = columns * rows;
  const auto rowSum = [&](size_t y) { return blended(rowSums, rows, blend, y); };
  const double wantedRow = u.y * rowSum(rows - 1);
  const size_t y = findCell(rows, wantedRow, rowSum);
  const auto whole = [&](size_t row) { return blended(alongRows, stride, blend, (row + 1) * columns - 1); };
  const double t = invertLinear((wantedRow - rowSum(y)) * double(rows - 1), whole(y), whole(y + 1));

  const auto inRow = [&](const std::vector<float>& table, size_t x) {
    return lerp(blended(table, stride, blend, y * columns + x),
                blended(table, stride, blend, (y + 1) * columns + x), t);
  };
  const auto along = [&](size_t x) { return inRow(alongRows, x); };
  const double wanted = u.x * along(columns - 1);
  const size_t x = findCell(columns, wanted, along);
  const double a = inRow(values, x), b = inRow(values, x + 1);
  const double s = invertLinear((wanted - along(x)) * double(columns - 1), a, b);
  return {{(double(x) + s) / double(columns - 1), (double(y) + t) / double(rows - 1)}, lerp(a, b, s)};
}

ParametricWarp::Point ParametricWarp::invert(const SliceBlend& blend, const Vec2d& p) const {
  const size_t stride = columns * rows;
  const GridCell x(p.x, columns), y(p.y, rows);
  const auto rowSum = [&](size_t row) { return blended(rowSums, rows, blend, row); };
  const auto whole = [&](size_t row) { return blended(alongRows, stride, blend, (row + 1) * columns - 1); };
  const double v = (rowSum(y.index) + linearIntegral(whole(y.index), whole(y.next), y.t) / double(rows - 1)) /
                   rowSum(rows - 1);

  const auto inRow = [&](const std::vector<float>& table, size_t column) {
    return lerp(blended(table, stride, blend, y.index * columns + column),
                blended(table, stride, blend, y.next * columns + column), y.t);
  };
  const double a = inRow(values, x.index), b = inRow(values, x.next), all = inRow(alongRows, columns - 1);
  const double part = inRow(alongRows, x.index) + linearIntegral(a, b, x.t) / double(columns - 1);
  return {{all > 0 ? part / all : p.x, v}, lerp(a, b, x.t)};
}

double ParametricWarp::pdf(const SliceBlend& blend, const Vec2d& p) const {
  const GridCell x(p.x, columns), y(p.y, rows);
  const auto at = [&](size_t column, size_t row) {
    return blended(values, columns * rows, blend, row * columns + column);
  };
  return lerp(lerp(at(x.index, y.index), at(x.next, y.index), x.t),
              lerp(at(x.index, y.next), at(x.next, y.next), x.t), y.t);
}

} // namespace recurse
