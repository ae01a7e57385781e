/** @file
 * Search for encoding, flip and shift: all combinations at a coarse level, the best of them at finer levels.
 */
#include "report/marking/alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace recurse {

namespace {

constexpr float NOTHING = std::numeric_limits<float>::quiet_NaN();
constexpr ValueEncoding FILE_ENCODINGS[] = {ValueEncoding::LINEAR, ValueEncoding::SRGB,
                                            ValueEncoding::GAMMA_22, ValueEncoding::DECODED};

/** Least cells of the longer side at the coarsest level; shifts reach an eighth of the shorter side.
 */
constexpr int COARSE_CELLS = 24;
constexpr int shiftReach(int cells) { return cells / 8; }
/** Cells that finer levels compare: enough to show a shift, and more take longer. */
constexpr double MOST_CELLS = 6000;
/** Combinations of encoding and flips that are followed to finer levels, besides the best of each encoding.
 */
constexpr size_t FOLLOWED = 3;
/** Prior probability of a wrong encoding, of a flip and of a shift: one exercise in twenty. */
constexpr double CHANGE_PRIOR = 1 / 20.0;
/** Light below which errors count as at a black pixel, as a fraction of the mean. */
constexpr double DARK_PART = 0.1;

/** Means over squares of pixels. */
struct Level {
  int width = 0, height = 0;
  size_t channels = 0;
  std::vector<float> values; ///< NaN or infinite where a pixel of the cell cannot be used

  const float* at(int x, int y) const { return &values[(size_t(y) * size_t(width) + size_t(x)) * channels]; }
};

Level averaged(const Image& image, int side) {
  Level out;
  out.width = image.width / side;
  out.height = image.height / side;
  out.channels = image.channels.size();
  out.values.resize(size_t(out.width) * size_t(out.height) * out.channels);
  std::vector<double> sum(out.channels);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      std::fill(sum.begin(), sum.end(), 0);
      for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) {
          const float* pixel = image.at(x * side + i, y * side + j);
          for (size_t c = 0; c < out.channels; ++c) sum[c] += double(pixel[c]);
        }
      float* cell = &out.values[(size_t(y) * size_t(out.width) + size_t(x)) * out.channels];
      for (size_t c = 0; c < out.channels; ++c) cell[c] = static_cast<float>(sum[c] / (side * side));
    }
  return out;
}

/** Picture with flips undone: original values in channels 0 to 2, decoded values in 3 to 5. */
Image candidatePicture(const Image& picture, const PictureChange& change) {
  Image out(picture.width, picture.height, {"R", "G", "B", "decoded.R", "decoded.G", "decoded.B"});
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const Rgb value = picture.rgb(change.isFlippedHorizontally ? picture.width - 1 - x : x,
                                    change.isFlippedVertically ? picture.height - 1 - y : y);
      for (int c = 0; c < 3; ++c) {
        out.at(x, y)[c] = value[c];
        out.at(x, y)[3 + c] = decoded(value[c], change.encoding);
      }
    }
  return out;
}

/** Mean of the first three channels. */
double meanLight(const Level& level) {
  double sum = 0, count = 0;
  for (int y = 0; y < level.height; ++y)
    for (int x = 0; x < level.width; ++x)
      for (size_t c = 0; c < 3; ++c) {
        const double value = std::abs(double(level.at(x, y)[c]));
        if (std::isfinite(value)) sum += value, ++count;
      }
  return sum > 0 ? sum / count : 1;
}

struct Fit {
  std::vector<double> factors;
  double score = std::numeric_limits<double>::infinity(); ///< ln of the mean residual, relative and squared
};

/** Cells of a reference for least squares. Cells at the border are excluded, so that all shifts use the
 * same cells. */
class FitReference {
 public:
  FitReference(const Level& level, int margin) : layers(level.channels / 3 - 1), matrix(layers * layers) {
    const double dark = DARK_PART * meanLight(level);
    const double inner = double(level.width - 2 * margin) * double(level.height - 2 * margin);
    const int step = std::max(1, static_cast<int>(std::sqrt(inner / MOST_CELLS)));
    for (int y = margin; y < level.height - margin; y += step)
      for (int x = margin; x < level.width - margin; x += step) {
        const float* values = level.at(x, y);
        if (!std::all_of(values, values + level.channels, [](float v) { return std::isfinite(v); })) continue;
        Cell& cell = cells.emplace_back();
        cell.x = x;
        cell.y = y;
        for (size_t c = 0; c < 3; ++c) {
          const double light = double(values[c]);
          cell.weights[c] = 1 / (light * light + dark * dark);
          for (size_t i = 0; i < layers; ++i) cell.light.push_back(double(values[3 * (i + 1) + c]));
        }
        addProducts(cell, 1, matrix);
      }
  }

  /** Fits the picture, which has original values in channels 0 to 2 and decoded values in 3 to 5. */
  Fit fit(const Level& picture, double pictureLight, const PictureChange& change) const {
    std::vector<double> matrixHere = matrix, vector(layers);
    std::vector<const float*> values(cells.size());
    size_t used = 0;
    for (size_t k = 0; k < cells.size(); ++k) {
      const Cell& cell = cells[k];
      const float* x = picture.at(cell.x + change.shiftX, cell.y + change.shiftY);
      if (!std::isfinite(x[0] + x[1] + x[2])) {
        addProducts(cell, -1, matrixHere);
        continue;
      }
      values[k] = x;
      ++used;
      for (size_t c = 0; c < 3; ++c) {
        const double weighted = cell.weights[c] * double(x[3 + c]);
        for (size_t i = 0; i < layers; ++i) vector[i] += weighted * cell.light[c * layers + i];
      }
    }
    Fit out{nonNegativeFactors(matrixHere, vector)};
    if (used > 0) out.score = residual(values, out.factors, DARK_PART * pictureLight, change.encoding);
    return out;
  }

 private:
  struct Cell {
    int x = 0, y = 0;
    double weights[3] = {};
    std::vector<double> light; ///< light of each layer, channel by channel
  };

  void addProducts(const Cell& cell, double sign, std::vector<double>& sum) const {
    for (size_t c = 0; c < 3; ++c) {
      const double* light = &cell.light[c * layers];
      for (size_t i = 0; i < layers; ++i) {
        const double weighted = sign * cell.weights[c] * light[i];
        for (size_t j = 0; j < layers; ++j) sum[i * layers + j] += weighted * light[j];
      }
    }
  }

  /** Residual in the encoding of the picture, relative to the picture: comparable between candidates. */
  double residual(const std::vector<const float*>& values, const std::vector<double>& factors, double dark,
                  ValueEncoding encoding) const {
    double sum = 0, count = 0;
    for (size_t k = 0; k < cells.size(); ++k) {
      if (!values[k]) continue;
      for (size_t c = 0; c < 3; ++c) {
        const double* light = &cells[k].light[c * layers];
        double y = 0;
        for (size_t i = 0; i < layers; ++i) y += factors[i] * light[i];
        const double value = double(values[k][c]);
        const double difference = value - double(encoded(static_cast<float>(y), encoding));
        // Loss of Geman and McClure: an outlier counts at most 1, however far.
        const double square = difference * difference / (value * value + dark * dark);
        sum += square / (1 + square);
      }
      count += 3;
    }
    return std::log(sum / count + std::numeric_limits<double>::min());
  }

  size_t layers;
  std::vector<Cell> cells;
  std::vector<double> matrix;
};

/** Side of a cell at the coarsest level [pixels]. */
int coarseSide(int width, int height) {
  int side = 1;
  while (std::max(width, height) / (2 * side) >= COARSE_CELLS) side *= 2;
  return side;
}

/** −2 ln of the prior probability of a shift. */
double shiftPrior(const PictureChange& change, int width, int height) {
  const int reach = shiftReach(std::min(width, height) / coarseSide(width, height));
  const double shifts = std::pow(2.0 * reach + 1, 2);
  return -2 * std::log(change.isShifted() ? CHANGE_PRIOR / shifts : 1 - CHANGE_PRIOR);
}

/** An encoding and flips, at the best shift. */
struct Candidate {
  PictureChange change; ///< shifts in cells of the level
  Fit fit;
  double shiftScore = std::numeric_limits<double>::infinity(); ///< −2 ln of the probability among shifts
  double score = std::numeric_limits<double>::infinity(); ///< −2 ln of the probability among candidates
};

class Search {
 public:
  Search(const Image& picture, const Image& reference)
      : picture(picture), reference(reference), side(coarseSide(picture.width, picture.height)) {}

  /** Evaluates all candidates at the coarse level, the best of them at finer levels; the best first. */
  std::vector<Candidate> run() {
    std::vector<Candidate> all;
    for (ValueEncoding encoding : FILE_ENCODINGS)
      for (int flips = 0; flips < 4; ++flips)
        all.push_back({{encoding, (flips & 1) != 0, (flips & 2) != 0}, {}});
    const int farthest = shiftReach(std::min(picture.width, picture.height) / side);
    findShifts(all, farthest, farthest);
    all = followed(all);
    for (int margin = farthest + 1; side > 1;) {
      side /= 2;
      margin *= 2;
      for (Candidate& c : all) {
        c.change.shiftX *= 2;
        c.change.shiftY *= 2;
      }
      findShifts(all, 1, margin);
    }
    return all;
  }

 private:
  /** The best candidates, and the best of each encoding. */
  static std::vector<Candidate> followed(const std::vector<Candidate>& sorted) {
    std::vector<Candidate> out;
    for (const Candidate& candidate : sorted) {
      const auto isSame = [&](const Candidate& c) { return c.change.encoding == candidate.change.encoding; };
      if (out.size() < FOLLOWED || std::none_of(out.begin(), out.end(), isSame)) out.push_back(candidate);
    }
    return out;
  }

  /** Tries all shifts up to `reach` cells away from the shifts of the candidates. */
  void findShifts(std::vector<Candidate>& all, int reach, int margin) const {
    const FitReference fitReference(averaged(reference, side), margin);
    for (Candidate& candidate : all) {
      const Level level = averaged(candidatePicture(picture, candidate.change), side);
      const double light = meanLight(level);
      const PictureChange start = candidate.change;
      candidate.shiftScore = std::numeric_limits<double>::infinity();
      for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx) {
          PictureChange change = start;
          change.shiftX += dx;
          change.shiftY += dy;
          const Fit fit = fitReference.fit(level, light, change);
          const double prior = shiftPrior(change, picture.width, picture.height);
          // Edges, which show shifts, are at different positions in each cell.
          const double score = COARSE_CELLS * COARSE_CELLS * fit.score + prior;
          if (score < candidate.shiftScore)
            candidate = {change, fit, score,
                         PATCHES * fit.score + priorScore(change, picture.width, picture.height)};
        }
    }
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.score < b.score; });
  }

  const Image &picture, &reference;
  int side; ///< side of a cell at the present level [pixels]
};

} // namespace

float decoded(float value, ValueEncoding encoding) {
  const float size = std::abs(value);
  switch (encoding) {
  case ValueEncoding::LINEAR:
    return value;
  case ValueEncoding::SRGB:
    return std::copysign(linearFromSrgb(size), value);
  case ValueEncoding::GAMMA_22:
    return std::copysign(std::pow(size, 2.2f), value);
  case ValueEncoding::DECODED:
    return std::copysign(srgbFromLinear(size), value);
  case ValueEncoding::TONE_CURVE: // a FittedCurve
    break;
  }
  return value;
}

float encoded(float linear, ValueEncoding encoding) {
  const float size = std::abs(linear);
  switch (encoding) {
  case ValueEncoding::LINEAR:
    return linear;
  case ValueEncoding::SRGB:
    return std::copysign(srgbFromLinear(size), linear);
  case ValueEncoding::GAMMA_22:
    return std::copysign(std::pow(size, 1 / 2.2f), linear);
  case ValueEncoding::DECODED:
    return std::copysign(linearFromSrgb(size), linear);
  case ValueEncoding::TONE_CURVE: // a FittedCurve
    break;
  }
  return linear;
}

std::vector<double> nonNegativeFactors(const std::vector<double>& matrix, const std::vector<double>& vector) {
  // Coordinate descent; smaller changes, or changes after this number of sweeps, are not significant.
  constexpr int SWEEPS = 100;
  constexpr double LEAST_CHANGE = 1e-5;
  const size_t n = vector.size();
  std::vector<double> factors(n, 1);
  for (int sweep = 0; sweep < SWEEPS; ++sweep) {
    double change = 0;
    for (size_t i = 0; i < n; ++i) {
      if (matrix[i * n + i] <= 0) continue;
      double rest = vector[i];
      for (size_t j = 0; j < n; ++j)
        if (j != i) rest -= matrix[i * n + j] * factors[j];
      const double factor = std::max(0.0, rest / matrix[i * n + i]);
      change = std::max(change, std::abs(factor - factors[i]));
      factors[i] = factor;
    }
    if (change < LEAST_CHANGE) break;
  }
  return factors;
}

Image undone(const Image& picture, const PictureChange& change) {
  Image out(picture.width, picture.height, {"R", "G", "B"});
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      int px = x + change.shiftX, py = y + change.shiftY;
      const bool is = px >= 0 && py >= 0 && px < picture.width && py < picture.height;
      if (change.isFlippedHorizontally) px = picture.width - 1 - px;
      if (change.isFlippedVertically) py = picture.height - 1 - py;
      const Rgb value = is ? picture.rgb(px, py) : Rgb(NOTHING);
      for (int c = 0; c < 3; ++c) out.at(x, y)[c] = decoded(value[c], change.encoding);
    }
  return out;
}

double priorScore(const PictureChange& change, int width, int height) {
  constexpr double WRONG_ENCODINGS = double(std::size(FILE_ENCODINGS)), WRONG_FLIPS = 3;
  const double encoding =
      change.encoding == ValueEncoding::LINEAR ? 1 - CHANGE_PRIOR : CHANGE_PRIOR / WRONG_ENCODINGS;
  const double flips = change.isFlipped() ? CHANGE_PRIOR / WRONG_FLIPS : 1 - CHANGE_PRIOR;
  return -2 * std::log(encoding * flips) + shiftPrior(change, width, height);
}

std::vector<double> fittedFactors(const Image& picture, const Stills& reference) {
  const Level level = averaged(candidatePicture(picture, {}), 1);
  return FitReference(averaged(reference.image, 1), 0).fit(level, meanLight(level), {}).factors;
}

std::vector<Alignment> findAlignments(const Image& picture, const Stills& reference) {
  std::vector<Alignment> out = {{{}, fittedFactors(picture, reference)}};
  for (const Candidate& candidate : Search(picture, reference.image).run())
    if (candidate.change != PictureChange()) out.push_back({candidate.change, candidate.fit.factors});
  return out;
}

} // namespace recurse
