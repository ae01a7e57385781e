/** @file
 * Evaluation of a convergence study: variance and bias, power laws, times.
 */
#include "recurse/report/converge/converge.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/core/math/hash.h"
#include "report/compare/comparable.h"

namespace recurse {

namespace {

constexpr double NONE = std::numeric_limits<double>::quiet_NaN();

/** Quantile of two-sided 95%; Student's with 60 degrees of freedom or more is within 2% of it. */
constexpr double QUANTILE_95 = 2;
/** Number of blocks of a picture that has enough pixels, and their largest side [pixels]. */
constexpr double BLOCKS = 256;
constexpr int LARGEST_BLOCK = 16;

void requireFinite(const Image& image, const std::string& name) {
  size_t bad = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) bad += !isFinite(image.rgb(x, y));
  if (bad > 0) throw Error(name + ": " + std::to_string(bad) + " pixels of the reference are not finite");
}

double relativeWeight(double reference) { return 1 / (reference * reference + REL_MSE_EPSILON); }

std::string shortNumber(double value, int digits = 3) { return formatted("%.*g", digits, value); }

std::string secondsText(double seconds) { return shortNumber(seconds) + " s"; }

} // namespace

std::string References::hash() const {
  Hash hash;
  for (const Image* image : {&r, &a, &b})
    hash.add(image->pixels.data(), image->pixels.size() * sizeof(float));
  return hash.text();
}

References makeReferences(const std::vector<Image>& images, const std::vector<std::string>& names) {
  if (images.empty() || images.size() > 3 || names.size() != images.size())
    throw Error("one, two or three references are needed", ExitStatus::BAD_USAGE);
  for (size_t i = 0; i < images.size(); ++i) {
    requireComparable(images[0], images[i], (names[i] + " has").c_str());
    requireFinite(images[i], names[i]);
  }
  References out;
  out.independent = images.size() > 1;
  const size_t first = images.size() == 3 ? 1 : 0;
  out.a = images[first];
  out.b = images[out.independent ? first + 1 : 0];
  out.r = images.size() == 2 ? meanImage(out.a, out.b) : images[0];
  if (!out.independent)
    out.description = names[0] + "; the errors and bias² include its own noise";
  else if (images.size() == 2)
    out.description = "r is the mean of a = " + names[0] + " and b = " + names[1];
  else
    out.description = "r = " + names[0] + ", a = " + names[1] + ", b = " + names[2];
  if (out.independent) out.description += "; " + referenceError(out.a, out.b).text();
  return out;
}

Estimate blockEstimate(const std::vector<double>& values, int width, int height) {
  const int side =
      std::clamp(static_cast<int>(std::sqrt(double(width) * double(height) / BLOCKS)), 1, LARGEST_BLOCK);
  struct Block {
    double sum = 0;
    size_t count = 0;
  };
  const int columns = (width + side - 1) / side, rows = (height + side - 1) / side;
  std::vector<Block> blocks(size_t(columns) * size_t(rows));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      Block& block = blocks[size_t(y / side) * size_t(columns) + size_t(x / side)];
      for (size_t c = 0; c < 3; ++c) {
        const double value = values[(size_t(y) * size_t(width) + size_t(x)) * 3 + c];
        if (std::isnan(value)) continue;
        block.sum += value;
        ++block.count;
      }
    }
  std::erase_if(blocks, [](const Block& block) { return block.count == 0; });
  double sum = 0, count = 0;
  for (const Block& block : blocks) {
    sum += block.sum;
    count += double(block.count);
  }
  if (blocks.empty()) return {NONE, NONE, NONE};
  const double mean = sum / count;
  if (blocks.size() < 2) return {mean, NONE, NONE};
  // Blocks at the border are smaller, so the mean is a ratio of sums (Cochran 1977, section 6.3).
  double squares = 0;
  for (const Block& block : blocks) {
    const double residual = block.sum - double(block.count) * mean;
    squares += residual * residual;
  }
  const double n = double(blocks.size()), error = std::sqrt(squares * n / (n - 1)) / count;
  return {mean, mean - QUANTILE_95 * error, mean + QUANTILE_95 * error};
}

ErrorSplit splitError(const std::vector<Image>& pictures, const References& references) {
  const size_t seeds = pictures.size();
  if (seeds < 2) throw Error("variance and bias need pictures of at least two seeds");
  for (const Image& picture : pictures) requireComparable(picture, references.r, "reference has");
  const int width = references.r.width, height = references.r.height;
  const size_t count = size_t(width) * size_t(height) * 3;
  std::vector<double> variance(count, NONE), bias2(count, NONE), relVariance(count, NONE),
      relBias2(count, NONE);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool finite = std::all_of(pictures.begin(), pictures.end(),
                                      [&](const Image& picture) { return isFinite(picture.rgb(x, y)); });
      if (!finite) continue;
      const Rgb r = references.r.rgb(x, y), a = references.a.rgb(x, y), b = references.b.rgb(x, y);
      for (int c = 0; c < 3; ++c) {
        double mean = 0, squares = 0;
        for (const Image& picture : pictures) mean += double(picture.at(x, y)[c]) / double(seeds);
        for (const Image& picture : pictures) {
          const double difference = double(picture.at(x, y)[c]) - mean;
          squares += difference * difference;
        }
        const size_t i = (size_t(y) * size_t(width) + size_t(x)) * 3 + size_t(c);
        variance[i] = squares / double(seeds - 1);
        // The squared mean over the seeds still contains a part of the variance.
        bias2[i] = (mean - double(a[c])) * (mean - double(b[c])) - variance[i] / double(seeds);
        const double weight = relativeWeight(double(r[c]));
        relVariance[i] = variance[i] * weight;
        relBias2[i] = bias2[i] * weight;
      }
    }
  const auto estimate = [&](const std::vector<double>& values) {
    return blockEstimate(values, width, height);
  };
  return {estimate(variance), estimate(bias2), estimate(relVariance), estimate(relBias2)};
}

ReferenceError referenceError(const Image& a, const Image& b) {
  const Image r = meanImage(a, b);
  std::vector<double> values(r.pixels.size());
  std::vector<double> pixels(values.size() / 3);
  for (size_t p = 0; p < pixels.size(); ++p) {
    const int x = static_cast<int>(p % size_t(r.width)), y = static_cast<int>(p / size_t(r.width));
    for (int c = 0; c < 3; ++c) {
      const double difference = double(a.at(x, y)[c]) - double(b.at(x, y)[c]);
      const double value = difference * difference / 4 * relativeWeight(double(r.at(x, y)[c]));
      values[p * 3 + size_t(c)] = value;
      pixels[p] += value;
    }
  }
  ReferenceError out;
  out.relMse = blockEstimate(values, r.width, r.height);
  const auto worst = static_cast<ptrdiff_t>(std::ceil(double(pixels.size()) * TRIMMED_FRACTION));
  std::partial_sort(pixels.begin(), pixels.begin() + worst, pixels.end(), std::greater<>());
  double sum = 0, worstSum = 0;
  for (double value : pixels) sum += value;
  for (ptrdiff_t i = 0; i < worst; ++i) worstSum += pixels[size_t(i)];
  out.worstShare = sum > 0 ? worstSum / sum : 0;
  return out;
}

std::string ReferenceError::text() const {
  std::string out = "relMSE of their mean " + shortNumber(relMse.value) +
                    " (95%: " + shortNumber(std::max(0.0, relMse.low)) + " to " + shortNumber(relMse.high) +
                    "; ε " + shortNumber(REL_MSE_EPSILON) + ", denominator r²+ε, no trim; from a−b)";
  if (worstShare > 0.3)
    out += ", " + shortNumber(100 * worstShare, 2) +
           "% of it in the worst 0.1% of the pixels: a few bright paths dominate, and more of them may be "
           "missing";
  return out;
}

ConvergeCell measureCell(const Image& picture, const References& references) {
  const Comparison c = references.independent
                           ? compareImages(picture, references.a, references.b, &references.r)
                           : compareImages(picture, references.r);
  ConvergeCell out;
  out.mse = c.mse[ALL_CHANNELS];
  out.relMse = c.relMse[ALL_CHANNELS];
  out.relMseTrimmed = c.relMseTrimmed[ALL_CHANNELS];
  out.mseNoiseFree = c.noiseFree ? c.mseNoiseFree[ALL_CHANNELS] : NONE;
  out.relMseNoiseFree = c.noiseFree ? c.relMseNoiseFree[ALL_CHANNELS] : NONE;
  out.relMseByScale = c.noiseFree ? c.relMseNoiseFreeByScale : c.relMseByScale;
  out.meanRatio = c.meanRatio[ALL_CHANNELS];
  out.nonFinite = c.nonFinite;
  return out;
}

std::optional<PowerLaw> fitPowerLaw(const Curve& curve) {
  double n = 0, meanX = 0, meanY = 0;
  for (const auto& [seconds, error] : curve)
    if (seconds > 0 && error > 0) {
      ++n;
      meanX += std::log(seconds);
      meanY += std::log(error);
    }
  if (n < 2) return std::nullopt;
  meanX /= n;
  meanY /= n;
  double xx = 0, xy = 0, yy = 0;
  for (const auto& [seconds, error] : curve)
    if (seconds > 0 && error > 0) {
      const double x = std::log(seconds) - meanX, y = std::log(error) - meanY;
      xx += x * x;
      xy += x * y;
      yy += y * y;
    }
  // Times that barely differ, such as budgets below the shortest possible render, have no slope.
  constexpr double SMALLEST_SPREAD = 0.03; // variance of the logarithm: two points a factor of 1.4 apart
  if (xx / n < SMALLEST_SPREAD) return std::nullopt;
  PowerLaw out;
  out.exponent = xy / xx;
  out.factor = std::exp(meanY - out.exponent * meanX);
  out.standardError = n > 2 ? std::sqrt(std::max(0.0, yy - out.exponent * xy) / (n - 2) / xx) : NONE;
  return out;
}

TimeToReach timeToReach(const Curve& curve, double error) {
  using Kind = TimeToReach::Kind;
  Curve points = curve;
  std::erase_if(points, [](const auto& p) { return !(p[0] > 0) || std::isnan(p[1]); });
  if (points.empty()) return {};
  if (points.front()[1] <= error) return {Kind::BEFORE, points.front()[0]};
  for (size_t i = 1; i < points.size(); ++i) {
    const auto& [t0, e0] = points[i - 1];
    const auto& [t1, e1] = points[i];
    if (e1 > error) continue;
    if (e1 <= 0) return {Kind::BETWEEN, t1}; // noise of a noise-free error; no interpolation
    const double part = std::log(e0 / error) / std::log(e0 / e1);
    return {Kind::BETWEEN, t0 * std::pow(t1 / t0, part)};
  }
  const std::optional<PowerLaw> fit = fitPowerLaw(points);
  if (!fit || fit->exponent >= 0) return {};
  constexpr double FARTHEST = 10;
  // Extrapolates from the last point with the slope of the fit, to a time after the last measurement.
  const double seconds = points.back()[0] * std::pow(error / points.back()[1], 1 / fit->exponent);
  if (seconds > FARTHEST * points.back()[0]) return {};
  return {Kind::BEYOND, seconds};
}

std::string TimeToReach::text() const {
  switch (kind) {
  case Kind::BETWEEN:
    return secondsText(seconds);
  case Kind::BEFORE:
    return "≤ " + secondsText(seconds);
  case Kind::BEYOND:
    return "≈ " + secondsText(seconds) + " (extrapolated)";
  default:
    return "not reached";
  }
}

std::vector<double> targetErrors(const std::vector<Curve>& curves) {
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (const Curve& curve : curves)
    for (const auto& [seconds, error] : curve)
      if (error > 0) {
        low = std::min(low, error);
        high = std::max(high, error);
      }
  std::vector<double> out;
  if (!(low <= high)) return out;
  for (int power = static_cast<int>(std::ceil(std::log10(high))); power >= std::floor(std::log10(low));
       --power)
    for (double digit : {5.0, 2.0, 1.0}) {
      const double target = digit * std::pow(10.0, power);
      if (target <= high && target >= low) out.push_back(target);
    }
  return out;
}

} // namespace recurse
