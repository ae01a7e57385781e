/** @file
 * Tabulated densities over the unit square, for image-based lights.
 */
#pragma once

#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

/** Density over the unit square that is bilinear in each cell of a grid, with values at the corners. */
class Distribution2d {
 public:
  /** A point of the square and its density. */
  struct Sample {
    Vec2d at;
    double pdf; ///< 0: no sample
  };

  /** Zero density. */
  Distribution2d() = default;
  /** Density in proportion to `corners`: (width + 1) · (height + 1) finite values >= 0, row by row from y =
   * 0; width and height at least 1. */
  Distribution2d(int width, int height, const std::vector<double>& corners);

  bool empty() const { return !(total > 0); }
  /** Samples by inversion: nearby u in [0, 1)² give nearby points. */
  Sample sample(const Vec2d& u) const;
  /** Density of sample() at a point. Outside of the square it is the density at the nearest point inside. */
  double pdf(const Vec2d& at) const;

 private:
  /** Number of cells in each entry of the partial sums along a row. */
  static constexpr size_t BLOCK = 16;

  const float* row(size_t y) const { return &values[y * (width + 1)]; }
  /** Four times the mean over a cell. */
  static double weight(const float* above, const float* below, size_t x) {
    return double(above[x]) + double(above[x + 1]) + double(below[x]) + double(below[x + 1]);
  }

  size_t width = 0, height = 0, blocks = 0;
  std::vector<float> values;     ///< scaled so that the largest is 1
  std::vector<double> rowSums;   ///< sums over all rows up to each
  std::vector<double> blockSums; ///< sums along each row up to the end of each block
  double total = 0;
};

/** Density over any rectangle of the unit square that is constant in each cell of a grid, by a summed-area
 * table. */
class WindowedDistribution2d {
 public:
  struct Window {
    Vec2d low{0}, high{1};
  };

  /** Zero density. */
  WindowedDistribution2d() = default;
  /** Density in proportion to width · height finite values >= 0, row by row from y = 0; width and height at
   * least 1. */
  WindowedDistribution2d(int width, int height, const std::vector<double>& cells);

  /** Sum over a window, relative to the largest cell; 0: empty, black, or less than 1e-12 of the whole. */
  double sum(const Window& window) const;
  /** Samples a point of a window whose sum is above 0, by u in [0, 1)². */
  Vec2d sample(const Window& window, const Vec2d& u) const;
  /** Density of sample() at a point of a window whose sum is `total`. */
  double pdf(double total, const Vec2d& at) const;

 private:
  double sumTo(double x, double y) const;

  size_t width = 0, height = 0;
  std::vector<float> values; ///< scaled so that the largest is 1
  std::vector<double> sums;  ///< sums over all cells above and to the left
};

} // namespace recurse
