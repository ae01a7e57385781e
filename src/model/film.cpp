/** @file
 * The film's estimate of its own error.
 */
#include "recurse/model/film.h"

#include <algorithm>
#include <limits>

namespace recurse {

void Film::add(const Film& other) {
  for (size_t i = 0; i < sums.size(); ++i) sums[i] += other.sums[i];
  for (size_t i = 0; i < pixels.size(); ++i) {
    const Pixel& p = other.pixels[i];
    pixels[i].weight += p.weight;
    pixels[i].luminance += p.luminance;
    pixels[i].luminanceSquared += p.luminanceSquared;
    pixels[i].samples += p.samples;
  }
  if (!other.splatPlane) return;
  enableSplats(other.splatPlane->unit());
  splatPlane->add(*other.splatPlane);
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
