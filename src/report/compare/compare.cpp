/** @file
 * Error measures: sums in double precision over the pixels in their order.
 */
#include "recurse/report/compare/compare.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "recurse/core/io/error.h"
#include "report/compare/comparable.h"

namespace recurse {

namespace {

constexpr double NOT_A_NUMBER = std::numeric_limits<double>::quiet_NaN();

/** Sums over pixels for each channel; the value of all channels is the mean of the three. */
struct ChannelSum {
  PerChannel sum{};
  void add(size_t channel, double value) { sum[channel] += value; }
  PerChannel mean(size_t count) const {
    PerChannel out{};
    for (size_t c = 0; c < 3; ++c) {
      out[c] = count > 0 ? sum[c] / double(count) : NOT_A_NUMBER;
      out[ALL_CHANNELS] += out[c] / 3;
    }
    return out;
  }
};

struct PixelError {
  size_t pixel = 0;
  std::array<double, 3> relative{};
  double mean() const { return (relative[0] + relative[1] + relative[2]) / 3; }
};

/** Order of errors: the larger first, equal ones by pixel, so that the choice is deterministic. */
bool worse(const PixelError& a, const PixelError& b) {
  return a.mean() != b.mean() ? a.mean() > b.mean() : a.pixel < b.pixel;
}

Rgb pixelOf(const Image& image, size_t pixel) {
  return image.rgb(static_cast<int>(pixel % size_t(image.width)),
                   static_cast<int>(pixel / size_t(image.width)));
}

struct ComparedTo {
  const Image& r;
  const Image* a = nullptr; ///< a and b: both or none
  const Image* b = nullptr;
};

constexpr size_t SHOWN_WORST = 5;

/** Sums over the finite pixels. */
struct Sums {
  ChannelSum value, reference, squared, relative, mape, smape;
  ChannelSum squaredFree, relativeFree; ///< without the noise of two independent references
  PerChannel maximum{}, peak{};
  std::vector<PixelError> errors;

  /** Adds the errors of x against r, and against the independent references a and b. */
  void add(size_t pixel, const Rgb& x, const Rgb& r, const Rgb& a, const Rgb& b) {
    PixelError& error = errors.emplace_back(PixelError{pixel, {}});
    for (int i = 0; i < 3; ++i) {
      const size_t c = size_t(i);
      const double px = x[i], pr = r[i], difference = px - pr, denominator = pr * pr + REL_MSE_EPSILON;
      value.add(c, px);
      reference.add(c, pr);
      squared.add(c, difference * difference);
      error.relative[c] = difference * difference / denominator;
      relative.add(c, error.relative[c]);
      mape.add(c, std::abs(difference) / (std::abs(pr) + MAPE_EPSILON));
      smape.add(c, std::abs(difference) / ((std::abs(px) + std::abs(pr)) / 2 + MAPE_EPSILON));
      maximum[c] = std::max(maximum[c], std::abs(difference));
      peak[c] = std::max(peak[c], pr);
      const double product = (px - double(a[i])) * (px - double(b[i]));
      squaredFree.add(c, product);
      relativeFree.add(c, product / denominator);
    }
  }
};

/** Sums over all finite pixels; pixels that are not finite are counted. */
Sums sumUp(const Image& image, const ComparedTo& references, Comparison& counts) {
  Sums sums;
  const size_t count = size_t(image.width) * size_t(image.height);
  sums.errors.reserve(count);
  for (size_t pixel = 0; pixel < count; ++pixel) {
    const Rgb x = pixelOf(image, pixel), r = pixelOf(references.r, pixel);
    const Rgb a = references.a ? pixelOf(*references.a, pixel) : r;
    const Rgb b = references.b ? pixelOf(*references.b, pixel) : r;
    if (!isFinite(r) || !isFinite(a) || !isFinite(b))
      ++counts.nonFiniteReference;
    else if (!isFinite(x))
      ++counts.nonFinite;
    else
      sums.add(pixel, x, r, a, b);
  }
  return sums;
}

void setMeans(Comparison& out, const Sums& sums) {
  out.mean = sums.value.mean(out.pixels);
  out.meanReference = sums.reference.mean(out.pixels);
  out.mse = sums.squared.mean(out.pixels);
  out.relMse = sums.relative.mean(out.pixels);
  out.mape = sums.mape.mean(out.pixels);
  out.smape = sums.smape.mean(out.pixels);
  if (out.noiseFree) {
    out.mseNoiseFree = sums.squaredFree.mean(out.pixels);
    out.relMseNoiseFree = sums.relativeFree.mean(out.pixels);
  }
  out.maximum = sums.maximum;
  out.maximum[ALL_CHANNELS] = std::max({sums.maximum[0], sums.maximum[1], sums.maximum[2]});
  PerChannel peak = sums.peak;
  peak[ALL_CHANNELS] = std::max({peak[0], peak[1], peak[2]});
  for (size_t c = 0; c < 4; ++c) {
    out.meanRatio[c] = out.meanReference[c] != 0 ? out.mean[c] / out.meanReference[c] : NOT_A_NUMBER;
    // log10(0) = −∞: equal pictures have an infinite ratio, a black reference none at all.
    out.psnr[c] = out.mse[c] > 0 || out.pixels == 0 ? 10 * std::log10(peak[c] * peak[c] / out.mse[c])
                                                    : std::numeric_limits<double>::infinity();
  }
}

/** Sets the worst pixels, and the mean without them. */
void setWorst(Comparison& out, std::vector<PixelError> errors, const Image& image, const Image& reference) {
  out.trimmedPixels = static_cast<size_t>(double(out.pixels) * TRIMMED_FRACTION);
  const size_t front = std::min(out.pixels, std::max(out.trimmedPixels, SHOWN_WORST));
  std::partial_sort(errors.begin(), errors.begin() + static_cast<ptrdiff_t>(front), errors.end(), worse);
  for (size_t i = 0; i < std::min(front, SHOWN_WORST); ++i) {
    const size_t pixel = errors[i].pixel;
    out.worst.push_back({static_cast<int>(pixel % size_t(image.width)),
                         static_cast<int>(pixel / size_t(image.width)), errors[i].mean(),
                         pixelOf(image, pixel), pixelOf(reference, pixel)});
  }
  // The trimmed sum is computed anew: subtracting the largest errors from the full sum would cancel digits.
  ChannelSum trimmed;
  for (size_t i = out.trimmedPixels; i < errors.size(); ++i)
    for (size_t c = 0; c < 3; ++c) trimmed.add(c, errors[i].relative[c]);
  out.relMseTrimmed = trimmed.mean(out.pixels - out.trimmedPixels);
}

Comparison compare(const Image& image, const ComparedTo& references) {
  Comparison out;
  out.noiseFree = references.a != nullptr;
  Sums sums = sumUp(image, references, out);
  out.pixels = sums.errors.size();
  setMeans(out, sums);
  if (out.noiseFree)
    out.relMseNoiseFreeByScale = errorByScale(image, *references.a, *references.b, references.r);
  out.relMseByScale = errorByScale(image, references.r, references.r, references.r);
  setWorst(out, std::move(sums.errors), image, references.r);
  return out;
}

} // namespace

void addFlip(Comparison& comparison, const Image& image, const Image& reference) {
  comparison.flip = ldrFlip(image, reference);
  comparison.hdrFlip = hdrFlip(image, reference);
}

Image meanImage(const Image& a, const Image& b) {
  requireComparable(a, b, "second reference has");
  Image mean(a.width, a.height, {"R", "G", "B"});
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      for (int c = 0; c < 3; ++c) mean.at(x, y)[c] = a.at(x, y)[c] + (b.at(x, y)[c] - a.at(x, y)[c]) * 0.5f;
  return mean;
}

Comparison compareImages(const Image& image, const Image& reference) {
  requireComparable(image, reference, "reference has");
  return compare(image, {reference});
}

Comparison compareImages(const Image& image, const Image& a, const Image& b, const Image* reference) {
  requireComparable(image, a, "first reference has");
  requireComparable(image, b, "second reference has");
  if (!reference) return compare(image, {meanImage(a, b), &a, &b});
  requireComparable(image, *reference, "reference has");
  return compare(image, {*reference, &a, &b});
}

} // namespace recurse
