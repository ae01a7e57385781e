/** @file
 * Observations for the factors of classes: means of pixels, their noise, and the sums of least squares.
 */
#pragma once

#include <vector>

#include "recurse/core/image/image.h"

namespace recurse {

/**
 * Sums of weighted least squares over the cells of a region. The black and the white pixels of a checkerboard
 * are two pictures a and b with independent noise. Products of a and b have no bias from the noise of the
 * reference, which makes the factors of ordinary least squares too small. Matrices are layers x layers, row
 * by row.
 */
struct ClassSums {
  std::vector<double> matrix;         ///< products of layers: weighted (a b' + b a') / 2
  std::vector<double> vector;         ///< products of layers and picture, weighted likewise
  std::vector<double> covariance;     ///< covariance of `vector` about matrix x factors
  std::vector<double> lost;           ///< products of layers and the light that clipping may have removed
  std::vector<double> ordinaryMatrix; ///< products of layers: weighted (a + b) (a + b)' / 4
  std::vector<double> ordinaryVector; ///< products of layers and picture, weighted likewise
  size_t cells = 0;                   ///< number of usable cells

  explicit ClassSums(size_t layers = 0)
      : matrix(layers * layers), vector(layers), covariance(layers * layers), lost(layers),
        ordinaryMatrix(layers * layers), ordinaryVector(layers) {}
  size_t layers() const { return vector.size(); }
  ClassSums& operator+=(const ClassSums& other);
  /** Covariance of `vector` where the lost light has an unknown factor, with standard deviation 1. */
  double covarianceWithLoss(size_t i, size_t j) const {
    return covariance[i * layers() + j] + lost[i] * lost[j];
  }
};

struct CellRange {
  int left = 0, top = 0, right = 0, bottom = 0; ///< range of cells; right and bottom excluded
};

/** Misfit of given factors in a region. */
struct Misfit {
  double chiSquare = 0;   ///< sum of squared residuals over their variances
  double count = 0;       ///< number of residuals
  double unexplained = 0; ///< RMS of the residual without its noise, over the RMS of the light
};

/** Squares of pixels of a picture and of a reference with class layers. */
class Cells {
 public:
  /** Averages pixels to cells. `reference` has R, G, B and three channels for each class. The picture has R,
   * G, B, and in three more channels, if it has them, the light that clipping may have removed. It is NaN
   * where it cannot be used. */
  Cells(const Image& picture, const Image& reference, int side);

  int width() const { return columns; }
  int height() const { return rows; }
  /** Sets the weight of every cell by the light around it, and its variance under these factors: noise of
   * picture and reference, and tolerances. Weights do not depend on the cell's own noise, or light in few
   * bright pixels would seem to be missing. */
  void weigh(const std::vector<double>& factors);
  ClassSums sums(const CellRange& range) const;
  Misfit misfit(const CellRange& range, const std::vector<double>& factors) const;
  /** Mean of −2 ln of the probability density of the cells' values under these factors. A cell is explained,
   * and differs by its variance, or it shows something else and has any value. */
  double surprise(const std::vector<double>& factors) const;

 private:
  const float* pictureAt(size_t cell, int half) const { return &means[(cell * 2 + size_t(half)) * stride]; }
  const float* layersAt(size_t cell, int half) const { return pictureAt(cell, half) + 3; }
  double predicted(size_t cell, int half, size_t channel, const std::vector<double>& factors) const;
  std::vector<double> meansNear(const std::vector<double>& values, int reach) const;
  template <class Value> double noiseOfMean(size_t cell, const Value& valueAt) const;
  std::vector<double> residualNoise(const std::vector<double>& factors) const;

  const Image &picture, &reference;
  int side, columns, rows;
  size_t layers, stride;
  std::vector<float> means; ///< by cell, black half then white: R, G, B of the picture, then of each layer
  std::vector<char> usable; ///< cell by cell
  std::vector<double> lost; ///< cell by cell, three channels, in the mean
  std::vector<float>
      layerNoise; ///< by cell, three channels of each layer: variance of the mean of its pixels
  std::vector<double> weights, variances; ///< cell by cell, three channels, of the mean
};

} // namespace recurse
