/** @file
 * Densities over the unit square, tabulated: for pictures that emit light.
 */
#pragma once

#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

/** A density over the unit square that is bilinear in each cell of a grid, between values at the corners. */
class Distribution2d {
 public:
  /** A point of the square and its density. */
  struct Sample {
    Vec2d at;
    double pdf; ///< 0: there is none
  };

  /** Density 0. */
  Distribution2d() = default;
  /** In proportion to `corners`: (width + 1) · (height + 1) finite values of at least 0, row by row. */
  Distribution2d(int width, int height, const std::vector<double>& corners);

  bool empty() const { return !(total > 0); }
  /** By inversion: neighbouring numbers in [0, 1) become neighbouring points. */
  Sample sample(const Vec2d& u) const;
  double pdf(const Vec2d& at) const;

 private:
  /** Sums along a row are kept for so many cells at a time. */
  static constexpr size_t BLOCK = 16;

  const float* row(size_t y) const { return &values[y * (width + 1)]; }
  /** Four times the mean over a cell. */
  static double weight(const float* above, const float* below, size_t x) {
    return double(above[x]) + double(above[x + 1]) + double(below[x]) + double(below[x + 1]);
  }

  size_t width = 0, height = 0, blocks = 0;
  std::vector<float> values;     ///< the largest is 1
  std::vector<double> rowSums;   ///< of all rows up to each
  std::vector<double> blockSums; ///< the same along each row
  double total = 0;
};

/** A density over any rectangle of the unit square that is constant in each cell of a grid: a summed-area
 * table. */
class WindowedDistribution2d {
 public:
  struct Window {
    Vec2d low{0}, high{1};
  };

  /** Density 0. */
  WindowedDistribution2d() = default;
  /** In proportion to width · height finite values of at least 0, row by row. */
  WindowedDistribution2d(int width, int height, const std::vector<double>& cells);

  /** Of the table in a window; 0 where there is nothing. */
  double sum(const Window& window) const;
  /** A point of a window whose sum is above 0. */
  Vec2d sample(const Window& window, const Vec2d& u) const;
  /** The density of sample() at a point of a window whose sum is `total`. */
  double pdf(double total, const Vec2d& at) const;

 private:
  double sumTo(double x, double y) const;

  size_t width = 0, height = 0;
  std::vector<float> values; ///< the largest is 1
  std::vector<double> sums;  ///< of all cells above and to the left
};

} // namespace recurse
