/** @file
 * Error estimate of the film.
 */
#include "recurse/model/film/film.h"

#include <algorithm>
#include <limits>

namespace recurse {

namespace {

/** Variances of the same mean: from the spread of samples and from the difference of half buffers. */
struct VariancePair {
  double ofSamples = 0, ofHalves = 0;
};

/** Sums over `reach` pixels before and after each pixel, along `lines` rows of `length` pixels, or with
 * `down` along columns. */
std::vector<VariancePair> sumsAlong(const std::vector<VariancePair>& values, int length, int lines, bool down,
                                    int reach) {
  std::vector<VariancePair> sums(values.size());
  for (int line = 0; line < lines; ++line) {
    const auto at = [&](int k) { return size_t(down ? k * lines + line : line * length + k); };
    for (int k = 0; k < length; ++k)
      for (int other = std::max(0, k - reach); other <= std::min(length - 1, k + reach); ++other) {
        sums[at(k)].ofSamples += values[at(other)].ofSamples;
        sums[at(k)].ofHalves += values[at(other)].ofHalves;
      }
  }
  return sums;
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

double Film::darkLuminance() const {
  constexpr double DARK = 0.1; // fraction of the mean
  double sum = 0;
  for (size_t i = 0; i < pixels.size(); ++i) sum += luminanceOf(i);
  return DARK * sum / double(pixels.size());
}

std::vector<double> Film::standardErrors() const {
  constexpr int AROUND = 8; // reach [pixels]: the difference of a single pixel's halves is too noisy
  const int width = pixelBounds.width(), height = pixelBounds.height();
  const double dark = darkLuminance();
  std::vector<VariancePair> relative(pixels.size());
  std::vector<double> errors(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    errors[i] = pixels[i].samples > 0 ? variance(i) / double(pixels[i].samples) : 0;
    const std::optional<double> byHalves = varianceByHalves(i);
    const double scale = std::max(luminanceOf(i), dark);
    if (byHalves && scale > 0) relative[i] = {errors[i] / (scale * scale), *byHalves / (scale * scale)};
  }
  const std::vector<VariancePair> around =
      sumsAlong(sumsAlong(relative, width, height, false, AROUND), height, width, true, AROUND);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const double ratio = around[i].ofSamples > 0 ? around[i].ofHalves / around[i].ofSamples : 1;
    errors[i] = std::sqrt(errors[i] * ratio + (splatPlane ? splatPlane->variance(i) : 0));
  }
  return errors;
}

double Film::relativeError() const {
  for (const Pixel& p : pixels)
    if (p.samples < MIN_SAMPLES) return std::numeric_limits<double>::infinity();
  const double dark = darkLuminance();
  if (!(dark > 0)) return 0; // a black picture
  std::vector<double> errors = standardErrors();
  for (size_t i = 0; i < pixels.size(); ++i) errors[i] /= std::max(luminanceOf(i), dark);
  const auto percentile = errors.begin() + std::ptrdiff_t(0.95 * double(errors.size() - 1));
  std::nth_element(errors.begin(), percentile, errors.end());
  return *percentile;
}

} // namespace recurse
