/** @file
 * Cells: means over the two halves of a checkerboard, with their weights and variances.
 */
#include "report/marking/cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recurse {

namespace {

/** Relative error of a cell that marks tolerate: bias of kernels, of caches, of depth limits. */
constexpr double CELL_TOLERANCE = 0.03;
/** Distance between corresponding pixels of two renderers [pixels], by filters of different widths. */
constexpr double PIXEL_TOLERANCE = 0.25;
/** Light below which errors are not visible, as a fraction of the mean. */
constexpr double UNSEEN_PART = 0.1;

/** Prior probability that a cell shows something that no factors explain, and the range of its values [ln].
 */
constexpr double UNEXPLAINED_PRIOR = 0.05, UNEXPLAINED_RANGE = 5;

constexpr double square(double x) { return x * x; }

} // namespace

ClassSums& ClassSums::operator+=(const ClassSums& other) {
  const auto add = [](std::vector<double>& sum, const std::vector<double>& values) {
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += values[i];
  };
  add(matrix, other.matrix);
  add(vector, other.vector);
  add(covariance, other.covariance);
  add(lost, other.lost);
  add(ordinaryMatrix, other.ordinaryMatrix);
  add(ordinaryVector, other.ordinaryVector);
  cells += other.cells;
  return *this;
}

Cells::Cells(const Image& picture, const Image& reference, int side)
    : picture(picture), reference(reference), side(side), columns(picture.width / side),
      rows(picture.height / side), layers(reference.channels.size() / 3 - 1), stride(3 + 3 * layers) {
  const size_t count = size_t(columns) * size_t(rows);
  means.resize(count * 2 * stride);
  usable.assign(count, 1);
  lost.assign(count * 3, 0);
  weights.assign(count * 3, 0);
  variances.assign(count * 3, 0);
  std::vector<double> sum(stride);
  for (size_t cell = 0; cell < count; ++cell) {
    const int left = static_cast<int>(cell % size_t(columns)) * side,
              top = static_cast<int>(cell / size_t(columns)) * side;
    if (picture.channels.size() > 3)
      for (int y = top; y < top + side; ++y)
        for (int x = left; x < left + side; ++x)
          for (size_t c = 0; c < 3; ++c) lost[cell * 3 + c] += double(picture.at(x, y)[3 + c]) / square(side);
    for (int half = 0; half < 2; ++half) {
      std::fill(sum.begin(), sum.end(), 0);
      for (int y = top; y < top + side; ++y)
        for (int x = left + (y + half) % 2; x < left + side; x += 2) {
          for (size_t c = 0; c < 3; ++c) sum[c] += double(picture.at(x, y)[c]);
          for (size_t c = 3; c < stride; ++c) sum[c] += double(reference.at(x, y)[c]);
        }
      for (size_t c = 0; c < stride; ++c) {
        const double mean = 2 * sum[c] / square(side);
        if (!std::isfinite(mean)) usable[cell] = 0;
        means[(cell * 2 + size_t(half)) * stride + c] = static_cast<float>(mean);
      }
    }
  }
  layerNoise.resize(count * 3 * layers);
  for (size_t i = 0; i < layerNoise.size(); ++i)
    layerNoise[i] = static_cast<float>(noiseOfMean(
        i / (3 * layers), [&](int x, int y) { return double(reference.at(x, y)[3 + i % (3 * layers)]); }));
}

double Cells::predicted(size_t cell, int half, size_t channel, const std::vector<double>& factors) const {
  const float* values = layersAt(cell, half);
  double sum = 0;
  for (size_t i = 0; i < layers; ++i) sum += factors[i] * double(values[3 * i + channel]);
  return sum;
}

/** Variance of the mean of `valueAt(x, y)` over a cell, from the checkerboard difference of each 2 x 2
 * pixels, in which constant brightness, slopes and straight edges cancel. */
template <class Value> double Cells::noiseOfMean(size_t cell, const Value& valueAt) const {
  const int left = static_cast<int>(cell % size_t(columns)) * side,
            top = static_cast<int>(cell / size_t(columns)) * side;
  double sum = 0;
  for (int y = top; y + 1 < top + side; y += 2)
    for (int x = left; x + 1 < left + side; x += 2)
      sum += square(valueAt(x, y) - valueAt(x + 1, y) - valueAt(x, y + 1) + valueAt(x + 1, y + 1));
  // Four pixels a square have four times the variance of one, which a mean over side² pixels divides.
  const double squares = square(side / 2);
  return sum / (4 * squares) / square(side);
}

/** Variance of the mean of the residual in each cell, by channel. */
std::vector<double> Cells::residualNoise(const std::vector<double>& factors) const {
  std::vector<double> noise(weights.size());
  for (size_t i = 0; i < noise.size(); ++i) {
    const size_t cell = i / 3, c = i % 3;
    if (!usable[cell]) continue;
    noise[i] = noiseOfMean(cell, [&](int x, int y) {
      const float* r = reference.at(x, y) + 3;
      double value = double(picture.at(x, y)[c]);
      for (size_t k = 0; k < layers; ++k) value -= factors[k] * double(r[3 * k + c]);
      return value;
    });
  }
  return noise;
}

/** Means over the usable cells up to `reach` away. */
std::vector<double> Cells::meansNear(const std::vector<double>& values, int reach) const {
  std::vector<double> out(values.size());
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      double sum[3] = {}, count = 0;
      for (int j = std::max(y - reach, 0); j <= std::min(y + reach, rows - 1); ++j)
        for (int i = std::max(x - reach, 0); i <= std::min(x + reach, columns - 1); ++i) {
          const size_t other = size_t(j) * size_t(columns) + size_t(i);
          if (!usable[other]) continue;
          for (size_t c = 0; c < 3; ++c) sum[c] += values[other * 3 + c];
          ++count;
        }
      const size_t cell = size_t(y) * size_t(columns) + size_t(x);
      for (size_t c = 0; c < 3; ++c) out[cell * 3 + c] = count > 0 ? sum[c] / count : 0;
    }
  return out;
}

void Cells::weigh(const std::vector<double>& factors) {
  std::vector<double> prediction(weights.size());
  double mean = 0, explained = 0, count = 0;
  const std::vector<double> ones(layers, 1);
  for (size_t cell = 0; cell < usable.size(); ++cell) {
    if (!usable[cell]) continue;
    for (size_t c = 0; c < 3; ++c) {
      prediction[cell * 3 + c] = (predicted(cell, 0, c, factors) + predicted(cell, 1, c, factors)) / 2;
      mean += predicted(cell, 0, c, ones);
      explained += predicted(cell, 0, c, factors);
    }
    count += 3;
  }
  const double dark = count > 0 && mean > 0 ? UNSEEN_PART * mean / count : 1;
  // The noise of a reference layer counts even where its class seems to be missing: in the reference, a class
  // may be a few bright pixels that no other picture has.
  std::vector<double> noiseFactors = factors;
  for (double& f : noiseFactors) f = std::max(f, mean > 0 ? explained / mean : 1);
  constexpr int LIGHT_REACH = 2, NOISE_REACH = 1;
  const std::vector<double> light = meansNear(prediction, LIGHT_REACH), noise = residualNoise(noiseFactors),
                            noiseNear = meansNear(noise, NOISE_REACH);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const size_t cell = size_t(y) * size_t(columns) + size_t(x);
      if (!usable[cell]) continue;
      for (size_t c = 0; c < 3; ++c) {
        const auto valueAt = [&](int i, int j) {
          i = std::clamp(i, 0, columns - 1);
          j = std::clamp(j, 0, rows - 1);
          const size_t other = size_t(j) * size_t(columns) + size_t(i);
          return usable[other] ? prediction[other * 3 + c] : prediction[cell * 3 + c];
        };
        const double slope =
            (square(valueAt(x + 1, y) - valueAt(x - 1, y)) + square(valueAt(x, y + 1) - valueAt(x, y - 1))) /
            square(2 * side);
        const size_t i = cell * 3 + c;
        weights[i] = 1 / (square(light[i]) + square(dark));
        // The own noise of a cell counts in full where it has bright pixels. A smaller one is known too
        // poorly.
        variances[i] = std::max(noise[i], noiseNear[i]) + square(PIXEL_TOLERANCE) * slope +
                       square(CELL_TOLERANCE) * (square(prediction[i]) + square(dark)) + square(lost[i]);
      }
    }
}

ClassSums Cells::sums(const CellRange& range) const {
  ClassSums out(layers);
  for (int y = range.top; y < range.bottom; ++y)
    for (int x = range.left; x < range.right; ++x) {
      const size_t cell = size_t(y) * size_t(columns) + size_t(x);
      if (!usable[cell]) continue;
      ++out.cells;
      const float *a = layersAt(cell, 0), *b = layersAt(cell, 1);
      for (size_t c = 0; c < 3; ++c) {
        const double xa = double(pictureAt(cell, 0)[c]), xb = double(pictureAt(cell, 1)[c]);
        const double half = weights[cell * 3 + c] / 2;
        // a and b have twice the variance of their mean.
        const double spread = 2 * square(half) * variances[cell * 3 + c];
        for (size_t i = 0; i < layers; ++i) {
          const double ai = double(a[3 * i + c]), bi = double(b[3 * i + c]);
          out.vector[i] += half * (ai * xb + bi * xa);
          out.lost[i] += half * (ai + bi) * lost[cell * 3 + c];
          out.ordinaryVector[i] += half / 2 * (ai + bi) * (xa + xb);
          for (size_t j = 0; j <= i; ++j) {
            const double aj = double(a[3 * j + c]), bj = double(b[3 * j + c]);
            out.matrix[i * layers + j] += half * (ai * bj + bi * aj);
            out.covariance[i * layers + j] += spread * (ai * aj + bi * bj);
            out.ordinaryMatrix[i * layers + j] += half / 2 * (ai + bi) * (aj + bj);
          }
          // Noise of the class in the picture, which few samples may not show: taken to be that of the
          // reference.
          out.covariance[i * layers + i] +=
              2 * square(half) * (ai * ai + bi * bi) * double(layerNoise[(cell * layers + i) * 3 + c]);
        }
      }
    }
  for (std::vector<double>* matrix : {&out.matrix, &out.covariance, &out.ordinaryMatrix})
    for (size_t i = 0; i < layers; ++i)
      for (size_t j = 0; j < i; ++j) (*matrix)[j * layers + i] = (*matrix)[i * layers + j];
  return out;
}

Misfit Cells::misfit(const CellRange& range, const std::vector<double>& factors) const {
  Misfit out;
  double residual = 0, squares = 0, light = 0, referenceLight = 0;
  const std::vector<double> ones(layers, 1);
  for (int y = range.top; y < range.bottom; ++y)
    for (int x = range.left; x < range.right; ++x) {
      const size_t cell = size_t(y) * size_t(columns) + size_t(x);
      if (!usable[cell]) continue;
      for (size_t c = 0; c < 3; ++c) {
        const double xa = double(pictureAt(cell, 0)[c]), xb = double(pictureAt(cell, 1)[c]);
        const double a = xa - predicted(cell, 0, c, factors), b = xb - predicted(cell, 1, c, factors);
        const double weight = weights[cell * 3 + c];
        out.chiSquare += square((a + b) / 2) / variances[cell * 3 + c];
        residual += weight * a * b;
        squares += square(weight * a * b);
        light += weight * xa * xb;
        referenceLight += weight * predicted(cell, 0, c, ones) * predicted(cell, 1, c, ones);
        ++out.count;
      }
    }
  light = std::max(light, referenceLight);
  // A few pixels that are bright by noise are no difference of a region.
  constexpr double DEVIATIONS = 3;
  if (light > 0 && residual > DEVIATIONS * std::sqrt(squares)) out.unexplained = std::sqrt(residual / light);
  return out;
}

double Cells::surprise(const std::vector<double>& factors) const {
  double sum = 0, count = 0;
  for (size_t cell = 0; cell < usable.size(); ++cell) {
    if (!usable[cell]) continue;
    for (size_t c = 0; c < 3; ++c) {
      const double x = (double(pictureAt(cell, 0)[c]) + double(pictureAt(cell, 1)[c])) / 2;
      const double difference = x - (predicted(cell, 0, c, factors) + predicted(cell, 1, c, factors)) / 2;
      // Densities in units of the tolerance. Noise of the reference does not make a density smaller, or
      // factors that are too small would explain more.
      const double explained = std::exp(-square(difference) / (2 * variances[cell * 3 + c]));
      const double unexplained = CELL_TOLERANCE * std::sqrt(2 * std::numbers::pi) / UNEXPLAINED_RANGE;
      sum -= 2 * std::log((1 - UNEXPLAINED_PRIOR) * explained + UNEXPLAINED_PRIOR * unexplained);
      ++count;
    }
  }
  return count > 0 ? sum / count : 0;
}

} // namespace recurse
