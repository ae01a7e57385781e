/** @file
 * The film's estimate of its own error.
 */
#include "recurse/model/film.h"

#include <algorithm>
#include <limits>

namespace recurse {

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

double Film::relativeError() const {
  double sum = 0;
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (pixels[i].samples < MIN_SAMPLES) return std::numeric_limits<double>::infinity();
    sum += luminanceOf(i);
  }
  const double floor = 0.1 * sum / double(pixels.size());
  if (!(floor > 0)) return 0; // a black picture
  std::vector<double> errors(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) errors[i] = standardError(i) / std::max(luminanceOf(i), floor);
  const auto percentile = errors.begin() + std::ptrdiff_t(0.95 * double(errors.size() - 1));
  std::nth_element(errors.begin(), percentile, errors.end());
  return *percentile;
}

} // namespace recurse
