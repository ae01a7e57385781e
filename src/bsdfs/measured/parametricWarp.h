/** @file
 * Tables over the unit square for each node of a grid of two parameters, linear between all nodes, and the
 * warps of the square that have these densities (Dupuy and Jakob 2018, "An Adaptive Parameterization for
 * Efficient Material Acquisition and Rendering", supplement).
 */
#pragma once

#include <array>
#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

/** Slices of a table around a pair of parameters, and their weights. */
struct SliceBlend {
  std::array<uint32_t, 4> slices{};
  std::array<float, 4> weights{};
  uint32_t count = 0;
};

/** Increasing nodes of both parameters; the slice index is first · (number of second) + second. */
class ParameterGrid {
 public:
  ParameterGrid(std::vector<float> firstNodes, std::vector<float> secondNodes)
      : first(std::move(firstNodes)), second(std::move(secondNodes)) {}
  size_t slices() const { return first.size() * second.size(); }
  /** Slices around (a, b); parameters are clamped to the outer nodes. */
  SliceBlend at(float a, float b) const;

 private:
  std::vector<float> first, second;
};

/** Cell of a coordinate in [0, 1] among equidistant nodes, and the position t in it. */
struct GridCell {
  GridCell(double x, size_t nodes) {
    const double scaled = std::clamp(x, 0.0, 1.0) * double(nodes - 1);
    index = std::min(static_cast<size_t>(scaled), nodes > 1 ? nodes - 2 : 0);
    next = std::min(index + 1, nodes - 1);
    t = scaled - double(index);
  }
  size_t index, next;
  double t;
};

/** Values at columns × rows nodes of the unit square; x goes along a row. */
template <class T> class SliceTable {
 public:
  SliceTable() = default;
  SliceTable(size_t columns, size_t rows, std::vector<T> values)
      : columns(columns), rows(rows), values(std::move(values)) {}

  T at(const SliceBlend& blend, const Vec2d& p) const {
    const GridCell x(p.x, columns), y(p.y, rows);
    const auto s = static_cast<float>(x.t), t = static_cast<float>(y.t);
    T sum = T(0);
    for (uint32_t i = 0; i < blend.count; ++i) {
      const T* const slice = &values[blend.slices[i] * columns * rows];
      const T *const above = slice + y.index * columns, *const below = slice + y.next * columns;
      sum += (above[x.index] * ((1 - s) * (1 - t)) + above[x.next] * (s * (1 - t)) +
              below[x.index] * ((1 - s) * t) + below[x.next] * (s * t)) *
             blend.weights[i];
    }
    return sum;
  }
  /** Value of a table that has one slice. */
  T at(const Vec2d& p) const { return at({{0}, {1}, 1}, p); }

 private:
  size_t columns = 0, rows = 0;
  std::vector<T> values;
};

/**
 * Density over the unit square, bilinear between nodes. The marginal density of the rows is inverted first,
 * then the density within the row. Each slice is normalised separately.
 */
class ParametricWarp {
 public:
  struct Point {
    Vec2d at;
    double pdf; ///< density at the warped point
  };

  ParametricWarp() = default;
  /** Needs at least 2 columns and rows, and values of at least 0. A slice of zeros becomes uniform. */
  ParametricWarp(size_t columns, size_t rows, std::vector<float> values);

  /** Warps uniform numbers in [0, 1). */
  Point sample(const SliceBlend& blend, const Vec2d& u) const;
  /** Uniform numbers that sample() warps to p, with the density at p. */
  Point invert(const SliceBlend& blend, const Vec2d& p) const;
  double pdf(const SliceBlend& blend, const Vec2d& p) const;

 private:
  double blended(const std::vector<float>& table, size_t stride, const SliceBlend& blend, size_t i) const {
    double sum = 0;
    for (uint32_t s = 0; s < blend.count; ++s)
      sum += double(blend.weights[s]) * double(table[blend.slices[s] * stride + i]);
    return sum;
  }
  void normalize(size_t slice);

  size_t columns = 0, rows = 0;
  std::vector<float> values;    ///< density at the nodes
  std::vector<float> alongRows; ///< integral of the density along a row, up to each node
  std::vector<float> rowSums;   ///< integral over whole rows, up to each row
};

} // namespace recurse
