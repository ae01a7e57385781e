/** @file
 * Dealing out samples.
 */
#include "recurse/transport/sampleAllocation.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "recurse/core/parallel.h"
#include "recurse/core/sampler.h"

namespace recurse {

namespace {

/** The pixels around one that say how much it varies: a square of (2 NEAR + 1)², without itself. */
constexpr int NEAR = 2;
/** Those that tell the photons' part from the eye paths'. */
constexpr int PAIRS = 4;
/** And those over which rare bright samples are spread. */
constexpr int WIDE = 12;
/** One pixel around may not count for more than so many times what is usual there. */
constexpr double CLIP = 10;
/** Of the samples of a pixel. */
constexpr double ROUND_NUMBER = 4;
/** The mean of squares over the square of the mean up to which values are no more than unequal. */
constexpr double EVEN_SPREAD = 2;

/** [first, end) of places; of those within `reach` of `at`, of `count`. */
struct Range {
  Range(size_t at, int reach, size_t count)
      : first(at - std::min(at, size_t(reach))), end(std::min(count, at + size_t(reach) + 1)) {}
  Range(size_t first, size_t end) : first(first), end(end) {}
  Range within(const Range& o) const { return {std::max(first, o.first), std::min(end, o.end)}; }
  size_t size() const { return end - first; }
  size_t first, end;
};

/** Sums over rectangles in constant time (Crow 1984, "Summed-Area Tables for Texture Mapping"). */
class AreaSums {
 public:
  AreaSums(const std::vector<double>& values, size_t width, size_t height)
      : stride(width + 1), sums(stride * (height + 1)) {
    for (size_t y = 0; y < height; ++y) {
      double row = 0;
      for (size_t x = 0; x < width; ++x) {
        row += values[y * width + x];
        sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + row;
      }
    }
  }
  double sum(const Range& x, const Range& y) const {
    return sums[y.end * stride + x.end] - sums[y.end * stride + x.first] - sums[y.first * stride + x.end] +
           sums[y.first * stride + x.first];
  }

 private:
  size_t stride;
  std::vector<double> sums;
};

} // namespace

int64_t SampleAllocation::stageEnd(int64_t sample) {
  if (sample >= LONGEST_STAGE) return (sample / LONGEST_STAGE + 1) * LONGEST_STAGE;
  int64_t end = EVEN;
  while (end <= sample) end *= 2;
  return end;
}

uint64_t SampleAllocation::hashOf(size_t pixel) const {
  return hashCombine(hashCombine(stage.seed, uint64_t(stage.first)), pixel);
}

int64_t SampleAllocation::pilots(int64_t from, int64_t sample) const {
  if (stage.first == 0) return sample - from;
  const auto before = [&](int64_t s) { return (s - stage.first + PILOT_PERIOD - 1) / PILOT_PERIOD; };
  return before(sample) - before(from);
}

uint64_t SampleAllocation::due(size_t pixel, int64_t sample) const {
  const Pixel& p = pixels[pixel];
  const auto done = uint64_t(sample - stage.first), all = uint64_t(stage.end - stage.first),
             pilotsDone = uint64_t(pilots(stage.first, sample)),
             pilotsAll = uint64_t(pilots(stage.first, stage.end));
  if (p.extra == 0) return p.before + pilotsDone;
  // Each may have a photon map of its own: first one sample in as many as possible of those without a pilot
  // sample, at even distances, and what is left evenly in all. Those of different pixels not at once.
  const uint64_t single = std::min<uint64_t>(p.extra, all - pilotsAll), hash = hashOf(pixel);
  const auto spread = [hash](uint64_t count, uint64_t part, uint64_t whole) {
    return whole > 0 ? (count * part + hash % whole) / whole : 0;
  };
  return p.before + pilotsDone + spread(single, done - pilotsDone, all - pilotsAll) +
         spread(p.extra - single, done, all);
}

void SampleAllocation::begin(int64_t sample, int64_t end, uint64_t seed, const Film& film) {
  if (stage.end == end) return; // an interrupted one
  const int64_t pilotsBefore = stage.pilots + (stage.end > 0 ? pilots(stage.first, stage.end) : 0);
  stage = {sample, end, pilotsBefore, seed};
  double left = double(end) * double(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    pixels[i].before = static_cast<uint32_t>(film.samples(i));
    pixels[i].extra = 0;
    left -= double(film.samples(i)) + double(pilots(sample, end));
  }
  if (sample == 0 || !(left > 0)) return;

  const std::vector<Told> pixelsTold = told();
  const double pilotsNow = double(pilots(sample, end)), most = MOST * double(end);
  const double maps = mapPerSample ? double(end) : 0;
  const auto extraOf = [&](size_t i, double scale) {
    const double has = double(pixels[i].before) + pilotsNow;
    const double wanted =
        std::max(scale * pixelsTold[i].eyeDeviation, std::min(scale * pixelsTold[i].deviation, maps));
    return std::clamp(wanted - has, 0.0, std::max(0.0, most - has));
  };
  // Sums by rows, so that they do not depend on the number of threads.
  std::vector<double> rows(height);
  const auto total = [&](double scale) {
    parallelFor(height, [&](size_t y) {
      rows[y] = 0;
      for (size_t i = y * width; i < (y + 1) * width; ++i) rows[y] += extraOf(i, scale);
    });
    double sum = 0;
    for (const double row : rows) sum += row;
    return sum;
  };
  double largest = 0, least = INFINITY;
  for (const Told& t : pixelsTold)
    if (t.eyeDeviation > 0) {
      largest = std::max(largest, t.deviation);
      least = std::min(least, t.eyeDeviation);
    }
  double scale = 0;
  if (largest > 0) {
    double low = 0, high = most / least;
    if (total(high) > left) {
      low = 1 / largest; // a sample for the most varied pixel: nothing yet
      // By the exponent: scales may be apart by many powers of ten.
      for (int step = 0; step < 50 && high > low * (1 + 1e-6); ++step) {
        const double middle = std::sqrt(low) * std::sqrt(high);
        (total(middle) > left ? high : low) = middle;
      }
      scale = low;
    } else {
      scale = high;
    }
  }
  // What no pixel has use for goes to all.
  const double rest = std::max(0.0, left - total(scale)) / double(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    // On average what is wanted, in round numbers: those are stratified better.
    const double has = double(pixels[i].before) + pilotsNow, extra = extraOf(i, scale) + rest;
    const double multiple = mapPerSample ? 1 : ROUND_NUMBER;
    const double above = (std::floor((has + extra) / multiple) + 1) * multiple - has;
    const double below = std::max(0.0, above - multiple);
    const double chance = double(hashOf(i) >> 11) * 0x1p-53;
    pixels[i].extra = static_cast<uint32_t>(chance * (above - below) < extra - below ? above : below);
  }
}

std::vector<SampleAllocation::Told> SampleAllocation::told() const {
  const double n = double(stage.pilots);
  const double floor2 = dark * dark;
  std::vector<double> variance(pixels.size()), deviation(pixels.size()), scale2(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    const Pixel& p = pixels[i];
    const double luminance = p.luminance / n;
    scale2[i] = luminance * luminance + floor2;
    if (!(scale2[i] > 0)) continue;
    variance[i] = std::max(0.0, (p.luminanceSquared - p.luminance * luminance) / (n - 1)) / scale2[i];
    deviation[i] = std::sqrt(variance[i]);
  }
  const AreaSums variances(variance, width, height), deviations(deviation, width, height);
  std::optional<AreaSums> pairVariances, pairDifferences;
  if (mapPerSample) {
    // Of pairs: the mean of both variances, and half the variance of the difference, which both pixels get.
    std::vector<double> both(pixels.size()), difference(pixels.size());
    for (size_t i = 0; i + 1 < pixels.size(); ++i) {
      if (i % width % 2 != 0 || i % width + 1 == width) continue;
      const Pixel &p = pixels[i], &q = pixels[i + 1];
      const double scale = (scale2[i] + scale2[i + 1]) / 2;
      if (!(scale > 0)) continue;
      const double shared = (q.pair - p.luminance * q.luminance / n) / (n - 1) / scale;
      both[i] = both[i + 1] = (variance[i] * scale2[i] + variance[i + 1] * scale2[i + 1]) / 2 / scale;
      difference[i] = difference[i + 1] = std::max(0.0, both[i] - shared);
    }
    pairVariances.emplace(both, width, height);
    pairDifferences.emplace(difference, width, height);
  }
  std::vector<Told> out(pixels.size());
  parallelFor(height, [&](size_t y) {
    for (size_t x = 0; x < width; ++x) {
      const size_t i = y * width + x;
      // What the pixels nearby have in common. A single bright sample there does not get far.
      const Range nearX(x, NEAR, width), nearY(y, NEAR, height);
      const double others = double(nearX.size() * nearY.size()) - 1;
      if (others == 0) continue; // a picture of one pixel
      double usual = -deviation[i];
      for (size_t v = nearY.first; v < nearY.end; ++v)
        for (size_t u = nearX.first; u < nearX.end; ++u) usual += deviation[v * width + u];
      usual = std::max(0.0, usual / others);
      const double clip = CLIP * usual * usual;
      double near = -std::min(variance[i], clip);
      for (size_t v = nearY.first; v < nearY.end; ++v)
        for (size_t u = nearX.first; u < nearX.end; ++u) near += std::min(variance[v * width + u], clip);
      near = std::max(0.0, near / others);
      // Where bright samples are rare, that some have been met here and none there says nothing: all around
      // expect their share of them.
      const Range wideX(x, WIDE, width), wideY(y, WIDE, height);
      const double all = double(wideX.size() * wideY.size()) - 1;
      const double squares = variances.sum(wideX, wideY) - variance[i],
                   means = deviations.sum(wideX, wideY) - deviation[i];
      const double rare = std::max(0.0, squares / all - EVEN_SPREAD * means * means / (all * all));
      out[i].deviation = out[i].eyeDeviation = std::sqrt(near + rare);
      if (!mapPerSample) continue;
      // Without the pair that the pixel is in.
      const Range pairsX(x, PAIRS, width), pairsY(y, PAIRS, height);
      const size_t left = x / 2 * 2;
      const Range ownX(left, std::min(left + 2, width)), ownY(y, y + 1);
      const auto partOf = [&](const AreaSums& sums) {
        return std::max(0.0, sums.sum(pairsX, pairsY) - sums.sum(ownX.within(pairsX), ownY));
      };
      const double whole = partOf(*pairVariances);
      if (whole > 0) out[i].eyeDeviation *= std::sqrt(std::min(1.0, partOf(*pairDifferences) / whole));
    }
  });
  if (mapPerSample) {
    // Neighbours see the same photons, so that what few passes say of a place is far off all around it: the
    // mean over the picture counts.
    double photons = 0;
    for (const Told& t : out) photons += square(t.deviation) - square(t.eyeDeviation);
    photons = std::max(0.0, photons / double(out.size()));
    // Eye paths are stratified, and what is left of e after n samples is less than e / n. As if the error
    // fell as n^-1.5, which it does at edges: too little of e costs less than too few maps.
    const double stratified = 1 / std::sqrt(double(stage.end));
    for (Told& t : out) {
      t.eyeDeviation *= std::sqrt(stratified);
      t.deviation = std::sqrt(square(t.eyeDeviation) + photons);
    }
  }
  return out;
}

} // namespace recurse
