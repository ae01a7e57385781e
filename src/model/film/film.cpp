/** @file
 * Error estimate of the film.
 */
#include "recurse/model/film/film.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "recurse/core/math/vector.h"

namespace recurse {

namespace {

/** Two values for each pixel of an image. */
using Pairs = std::vector<std::array<double, 2>>;

/** Means over the pixels at most `reach` before and after each pixel, along `lines` rows of `length` pixels,
 * or with `down` along columns. */
Pairs meansAlong(const Pairs& values, int length, int lines, bool down, int reach) {
  Pairs means(values.size());
  for (int line = 0; line < lines; ++line) {
    const auto at = [&](int k) { return size_t(down ? k * lines + line : line * length + k); };
    for (int k = 0; k < length; ++k) {
      const int begin = std::max(0, k - reach), end = std::min(length, k + reach + 1);
      for (size_t value = 0; value < 2; ++value) {
        double sum = 0;
        for (int other = begin; other < end; ++other) sum += values[at(other)][value];
        means[at(k)][value] = sum / (end - begin);
      }
    }
  }
  return means;
}

/** Means over squares of pixels around each pixel of an image. */
Pairs meansAround(const Pairs& values, const PixelBounds& bounds) {
  constexpr int REACH = 8; // [pixels]: the difference of a single pixel's halves is too noisy
  const Pairs means = meansAlong(values, bounds.width(), bounds.height(), false, REACH);
  return meansAlong(means, bounds.height(), bounds.width(), true, REACH);
}

} // namespace

void Film::add(const Film& other) {
  for (size_t i = 0; i < sums.size(); ++i) sums[i] += other.sums[i];
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i].add(other.pixels[i]);
  if (!other.splatPlane) return;
  enableSplats(other.splatPlane->unit());
  splatPlane->add(*other.splatPlane);
}

std::vector<Film::StatePart> Film::stateParts() {
  std::vector<StatePart> out{{std::as_writable_bytes(std::span(sums)), sizeof(LongSum),
                              [](const void* from, void* into, size_t count) {
                                for (size_t i = 0; i < count; ++i)
                                  static_cast<LongSum*>(into)[i] += static_cast<const LongSum*>(from)[i];
                              }},
                             {std::as_writable_bytes(std::span(pixels)), sizeof(Pixel),
                              [](const void* from, void* into, size_t count) {
                                for (size_t i = 0; i < count; ++i)
                                  static_cast<Pixel*>(into)[i].add(static_cast<const Pixel*>(from)[i]);
                              }}};
  if (!splatPlane) return out;
  const auto parts = splatPlane->state();
  for (size_t i = 0; i + 1 < parts.size(); ++i)
    out.push_back({parts[i], sizeof(WideSum), SplatPlane::addSums});
  out.push_back({parts.back(), parts.back().size(), SplatPlane::addFigures});
  return out;
}

std::vector<size_t> Film::nearestSampled(int reach) const {
  constexpr size_t NONE = std::numeric_limits<size_t>::max();
  std::vector<size_t> nearest(pixels.size(), NONE), front, next;
  for (size_t i = 0; i < pixels.size(); ++i)
    if (pixels[i].samples > 0) front.push_back(nearest[i] = i);
  if (front.size() == pixels.size()) return {};
  const auto width = size_t(pixelBounds.width());
  for (int step = 0; step < reach && !front.empty(); ++step, front.swap(next)) {
    next.clear();
    const auto spread = [&](size_t from, size_t to) {
      if (nearest[to] != NONE) return;
      nearest[to] = nearest[from];
      next.push_back(to);
    };
    for (const size_t i : front) {
      if (i % width > 0) spread(i, i - 1);
      if (i % width + 1 < width) spread(i, i + 1);
      if (i >= width) spread(i, i - width);
      if (i + width < pixels.size()) spread(i, i + width);
    }
  }
  for (size_t i = 0; i < nearest.size(); ++i)
    if (nearest[i] == NONE) nearest[i] = i;
  return nearest;
}

std::optional<double> Film::varianceByHalves(size_t pixel) const {
  const Pixel& p = pixels[pixel];
  const double n = double(p.samples), half = double(p.halfSamples), other = n - half;
  if (!(half > 0 && other > 0)) return std::nullopt;
  const double difference = p.halfLuminance / half - (p.luminance - p.halfLuminance) / other;
  return difference * difference * half * other / (n * n);
}

double Film::chanceOfBlack(size_t pixel) const {
  const Pixel& p = pixels[pixel];
  if (!(p.luminance > 0)) return 1;
  const double mean = p.luminance / double(p.samples);
  return std::pow(1 - mean * mean / (mean * mean + variance(pixel)), double(p.samples));
}

double Film::darkLuminance() const {
  constexpr double DARK = 0.1; // fraction of the mean
  double sum = 0;
  for (size_t i = 0; i < pixels.size(); ++i) sum += luminanceOf(i);
  return DARK * sum / double(pixels.size());
}

std::vector<double> Film::standardErrors() const {
  const double dark = darkLuminance();
  bool hasBlack = false;
  std::vector<double> variances(pixels.size()), errors(pixels.size());
  Pairs ofSamplesAndHalves(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    variances[i] = pixels[i].samples > 0 ? variance(i) / double(pixels[i].samples) : 0;
    const std::optional<double> byHalves = varianceByHalves(i);
    const double scale2 = square(std::max(luminanceOf(i), dark));
    if (byHalves && scale2 > 0) ofSamplesAndHalves[i] = {variances[i] / scale2, *byHalves / scale2};
  }
  ofSamplesAndHalves = meansAround(ofSamplesAndHalves, pixelBounds);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const auto [ofSamples, ofHalves] = ofSamplesAndHalves[i];
    if (ofSamples > 0) variances[i] *= ofHalves / ofSamples;
    errors[i] = std::sqrt(variances[i] + (splatPlane ? splatPlane->variance(i) : 0));
    hasBlack = hasBlack || !(luminanceOf(i) > 0);
  }
  if (!hasBlack) return errors;
  Pairs varianceAndLuminance(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i)
    varianceAndLuminance[i] = {variances[i] * chanceOfBlack(i), luminanceOf(i)};
  varianceAndLuminance = meansAround(varianceAndLuminance, pixelBounds);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const auto [around, luminance] = varianceAndLuminance[i];
    if (!(luminanceOf(i) > 0) && luminance > 0)
      errors[i] = std::sqrt(around) * dark / std::max(luminance, dark);
  }
  return errors;
}

double Film::relativeError() const {
  for (const Pixel& p : pixels)
    if (p.samples < MIN_SAMPLES) return std::numeric_limits<double>::infinity();
  const double dark = darkLuminance();
  const std::vector<double> errors = standardErrors();
  std::vector<double> relative;
  for (size_t i = 0; i < pixels.size(); ++i)
    if (luminanceOf(i) > 0 || errors[i] > 0) relative.push_back(errors[i] / std::max(luminanceOf(i), dark));
  if (relative.empty()) return 0; // a black picture
  const auto percentile = relative.begin() + std::ptrdiff_t(0.95 * double(relative.size() - 1));
  std::nth_element(relative.begin(), percentile, relative.end());
  return *percentile;
}

} // namespace recurse
