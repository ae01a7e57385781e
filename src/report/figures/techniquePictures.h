/** @file
 * Pictures of the contributions of samples, sorted by technique.
 */
#pragma once

#include <functional>
#include <vector>

#include "recurse/core/image/image.h"
#include "recurse/render/recordPixels.h"

namespace recurse {

/** Sums `value(record, contribution)` into picture `which(record, contribution)` of `pictures` for each
 * contribution of a pixel's record, with the film's white balance; a negative index leaves it out. The film's
 * clamp is not applied: it is a property of the whole sample. */
template <class Which, class Value>
void addContributions(const FilmSettings& film, const PathRecorder& record, int x, int y,
                      std::vector<Image>& pictures, const Which& which, const Value& value) {
  for (size_t s = 0; s < record.samples().size(); ++s) {
    const RecordedSample& sample = record.samples()[s];
    for (size_t i = sample.firstContribution; i < record.endContribution(s); ++i) {
      const RecordedContribution& c = record.contributions()[i];
      const int index = which(record, c);
      if (index < 0) continue;
      const Rgb light = value(record, c) * (sample.filterWeight * sample.rayWeight);
      const Rgb sum = film.whiteBalance ? *film.whiteBalance * light : light;
      for (int channel = 0; channel < 3; ++channel) pictures[size_t(index)].at(x, y)[channel] += sum[channel];
    }
  }
}

/** Sum of the filter weights of a pixel's record. */
inline float filterWeights(const PathRecorder& record) {
  float sum = 0;
  for (const RecordedSample& s : record.samples()) sum += s.filterWeight;
  return sum;
}

} // namespace recurse
