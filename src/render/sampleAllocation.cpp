/** @file
 * Allocation of adaptive samples to pixels.
 */
#include "recurse/render/sampleAllocation.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "recurse/core/sampling/sampler.h"
#include "recurse/core/threads/parallel.h"

namespace recurse {

namespace {

/** Reaches of the two squares of (2 n + 1)² pixels, centre excluded, whose deviations predict a pixel's. Both
 * have equal weight. */
constexpr int INNER_REACH = 1, OUTER_REACH = 2;
/** Reach of the square in which photon variance is separated from camera-path variance [pixels]. */
constexpr int PAIRS = 4;
/** Reach of the square over which rare bright samples are averaged [pixels]. */
constexpr int WIDE = 12;
/** Weight of rare samples: they decide only where usual deviations are nearly equal. */
constexpr double RARE_WEIGHT = 0.01;
/** Rounding step of predictions, above the rounding errors of area sums. */
constexpr double MIN_STEP = 1e-10;
/** Maximum ratio of mean square to squared mean of ordinary deviations; above it, rare samples cause them. */
constexpr double EVEN_SPREAD = 2;
/** Largest number of classes of pixels with a similar predicted variance. */
constexpr size_t MAX_CLASSES = 64;
/** Sample counts of pixels are multiples of it, for better stratification. */
constexpr double ROUND_NUMBER = 4;

/** Index range [first, end); or the indices within `reach` of `at`, below `count`. */
struct Range {
  Range(size_t at, int reach, size_t count)
      : first(at - std::min(at, size_t(reach))), end(std::min(count, at + size_t(reach) + 1)) {}
  Range(size_t first, size_t end) : first(first), end(end) {}
  Range within(const Range& o) const { return {std::max(first, o.first), std::min(end, o.end)}; }
  size_t first, end;
};

/** Square of pixels around one. */
struct PixelSquare {
  PixelSquare(size_t pixel, int reach, size_t width, size_t height)
      : x(pixel % width, reach, width), y(pixel / width, reach, height) {}
  Range x, y;
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

/** Quarter of the pixels of a picture, number 0 to 3, with a random one of each 2 x 2: its samples are
 * allocated by the samples of the others. */
struct Quarter {
  static constexpr size_t COUNT = 4;
  size_t number, width; ///< width of the picture
  bool has(size_t pixel) const {
    const size_t x = pixel % width, y = pixel / width;
    return (x % 2 + y % 2 * 2 + hashCombine(x / 2, y / 2)) % COUNT == number;
  }
};

std::vector<double> zeroIn(const Quarter& quarter, std::vector<double> values) {
  for (size_t i = 0; i < values.size(); ++i)
    if (quarter.has(i)) values[i] = 0;
  return values;
}

/** Means of a value over squares, without the pixels of a quarter. */
class MeansOfOthers {
 public:
  /** `counts`: sums of 1 over the other pixels; must outlive the means. */
  MeansOfOthers(const Quarter& quarter, const AreaSums& counts, const std::vector<double>& values,
                size_t width, size_t height)
      : quarter(quarter), counts(counts), values(zeroIn(quarter, values)), width(width), height(height),
        sums(this->values, width, height) {}
  /** Mean over the square around a pixel, which does not count itself. */
  double around(size_t pixel, int reach) const {
    const PixelSquare s(pixel, reach, width, height);
    const double count = counts.sum(s.x, s.y) - (quarter.has(pixel) ? 0 : 1);
    return count > 0 ? std::max(0.0, sums.sum(s.x, s.y) - values[pixel]) / count : 0;
  }

 private:
  const Quarter quarter;
  const AreaSums& counts;
  const std::vector<double> values;
  const size_t width, height;
  const AreaSums sums;
};

/** Mean of `value` as a function of `key`, over classes of at least MIN_CLASS pixels outside of a quarter
 * with similar keys. */
class ClassMeans {
 public:
  ClassMeans(const Quarter& quarter, const std::vector<double>& key, const std::vector<double>& value) {
    std::vector<uint32_t> order;
    for (size_t i = 0; i < key.size(); ++i)
      if (!quarter.has(i)) order.push_back(static_cast<uint32_t>(i));
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
      return key[a] != key[b] ? key[a] < key[b] : a < b; // a total order keeps sums reproducible
    });
    const size_t size = std::max(SampleAllocation::MIN_CLASS, (order.size() + MAX_CLASSES - 1) / MAX_CLASSES);
    for (size_t first = 0, end = 0; first < order.size(); first = end) {
      end = std::min(first + size, order.size());
      while (end < order.size() && key[order[end]] == key[order[end - 1]]) ++end;
      if (order.size() - end < size) end = order.size();
      double sum = 0;
      for (size_t k = first; k < end; ++k) sum += value[order[k]];
      largest.push_back(key[order[end - 1]]);
      means.push_back(sum / double(end - first));
    }
  }
  /** 0 if there is no other pixel. */
  double at(double key) const {
    if (means.empty()) return 0;
    const auto found = std::lower_bound(largest.begin(), largest.end() - 1, key);
    return means[size_t(found - largest.begin())];
  }

 private:
  std::vector<double> largest, means; ///< largest key of each class, ascending; mean of its values
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

int64_t SampleAllocation::pilotsUpTo(int64_t sample) const {
  if (sample <= EVEN) return sample;
  if (mapPerSample) return EVEN + (sample - EVEN) / PILOT_PERIOD;
  return std::max(EVEN, sample / PILOT_PERIOD / (2 * BLOCK) * 2 * BLOCK); // in whole pairs of blocks
}

int64_t SampleAllocation::pilots(int64_t from, int64_t sample) const {
  const int64_t length = stage.end - stage.first, all = pilotsUpTo(stage.end) - pilotsUpTo(stage.first);
  const auto before = [&](int64_t s) { return ((s - stage.first) * all + length - 1) / length; };
  return before(sample) - before(from);
}

uint64_t SampleAllocation::due(size_t pixel, int64_t sample) const {
  const Pixel& p = pixels[pixel];
  const auto done = uint64_t(sample - stage.first), all = uint64_t(stage.end - stage.first),
             pilotsDone = uint64_t(pilots(stage.first, sample)),
             pilotsAll = uint64_t(pilots(stage.first, stage.end));
  if (p.extra == 0) return p.before + pilotsDone;
  // Each sample may have a photon map of its own. First, extras go to as many samples without a pilot as
  // possible, evenly spaced; the rest is spread over all. The hash offsets pixels against each other.
  const uint64_t single = std::min<uint64_t>(p.extra, all - pilotsAll), hash = hashOf(pixel);
  const auto spread = [hash](uint64_t count, uint64_t part, uint64_t whole) {
    return whole > 0 ? (count * part + hash % whole) / whole : 0;
  };
  return p.before + pilotsDone + spread(single, done - pilotsDone, all - pilotsAll) +
         spread(p.extra - single, done, all);
}

void SampleAllocation::addStagePilots() {
  const auto before = uint64_t(pilotsUpTo(stage.first)), count = uint64_t(pilots(stage.first, stage.end));
  parallelFor(height, [&](size_t y) {
    for (uint64_t n = before; n < before + count; ++n)
      for (size_t i = y * width; i < (y + 1) * width; ++i) {
        Pixel& p = pixels[i];
        const auto luminance = double(stagePilots[i * MAX_PILOTS + size_t(n - before)]);
        p.luminance += luminance;
        p.luminanceSquared += luminance * luminance;
        p.difference += n / BLOCK % 2 == 0 ? luminance : -luminance;
        if ((n + 1) % (2 * BLOCK) == 0) {
          p.differencesSquared += p.difference * p.difference;
          p.difference = 0;
        }
        if (mapPerSample) p.pair = i % width % 2 == 0 ? luminance : p.pair + pixels[i - 1].pair * luminance;
        p.pilots = before + count;
      }
  });
}

std::vector<std::byte> SampleAllocation::plan() const {
  std::vector<std::byte> out(sizeof stage + pixels.size() * 2 * sizeof(uint32_t));
  std::memcpy(out.data(), &stage, sizeof stage);
  std::byte* to = out.data() + sizeof stage;
  for (const Pixel& p : pixels)
    for (const uint32_t& number : {p.before, p.extra}) {
      std::memcpy(to, &number, sizeof number);
      to += sizeof number;
    }
  return out;
}

void SampleAllocation::setPlan(std::span<const std::byte> plan) {
  std::memcpy(&stage, plan.data(), sizeof stage);
  const std::byte* from = plan.data() + sizeof stage;
  for (Pixel& p : pixels)
    for (uint32_t* number : {&p.before, &p.extra}) {
      std::memcpy(number, from, sizeof *number);
      from += sizeof *number;
    }
}

void SampleAllocation::begin(int64_t sample, int64_t end, uint64_t seed) {
  if (stage.end == end) return; // continues an interrupted stage
  std::vector<uint64_t> has(pixels.size());
  if (stage.end > 0) {
    for (size_t i = 0; i < pixels.size(); ++i) has[i] = due(i, stage.end);
    addStagePilots();
  }
  stage = {sample, end, seed};
  for (size_t i = 0; i < pixels.size(); ++i) {
    pixels[i].before = static_cast<uint32_t>(has[i]);
    pixels[i].extra = 0;
  }
  if (sample == 0) return;

  const std::vector<Need> need = needs();
  for (size_t quarter = 0; quarter < Quarter::COUNT; ++quarter) allocateQuarter(quarter, need, sample, end);
}

void SampleAllocation::allocateQuarter(size_t number, const std::vector<Need>& need, int64_t sample,
                                       int64_t end) {
  const Quarter quarter{number, width};
  const double pilotsNow = double(pilots(sample, end)), most = MAX_SHARE * double(end);
  const double maps = mapPerSample ? double(end) : 0;
  double left = 0, largest = 0, least = INFINITY;
  std::vector<size_t> own;
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (!quarter.has(i)) continue;
    own.push_back(i);
    left += double(end) - double(pixels[i].before) - pilotsNow;
    if (!(need[i].eye > 0)) continue;
    largest = std::max(largest, need[i].all);
    least = std::min(least, need[i].eye);
  }
  left = std::max(0.0, left);
  const auto extraOf = [&](size_t i, double scale) {
    const double has = double(pixels[i].before) + pilotsNow;
    const double wanted = std::max(scale * need[i].eye, std::min(scale * need[i].all, maps));
    return std::clamp(wanted - has, 0.0, std::max(0.0, most - has));
  };
  // Sums by blocks do not depend on the number of threads.
  constexpr size_t SUMMED = 1024;
  std::vector<double> sums((own.size() + SUMMED - 1) / SUMMED);
  const auto total = [&](double scale) {
    parallelFor(sums.size(), [&](size_t block) {
      sums[block] = 0;
      for (size_t k = block * SUMMED; k < std::min(own.size(), (block + 1) * SUMMED); ++k)
        sums[block] += extraOf(own[k], scale);
    });
    double sum = 0;
    for (const double s : sums) sum += s;
    return sum;
  };
  double scale = 0;
  if (largest > 0) {
    double low = 0, high = most / least;
    if (total(high) > left) {
      low = 1 / largest; // one sample for the most varied pixel: no extra yet
      // Bisection of the exponent, because the bounds may differ by many orders of magnitude.
      for (int step = 0; step < 50 && high > low * (1 + 1e-6); ++step) {
        const double middle = std::sqrt(low) * std::sqrt(high);
        (total(middle) > left ? high : low) = middle;
      }
      scale = low;
    } else {
      scale = high;
    }
  }
  // Samples that no pixel needs are divided among all.
  const double rest = std::max(0.0, left - total(scale)) / std::max(1.0, double(own.size()));
  for (const size_t i : own) {
    // Random rounding to multiples, which are stratified better, unbiased on average.
    const double has = double(pixels[i].before) + pilotsNow, extra = extraOf(i, scale) + rest;
    const double multiple = mapPerSample ? 1 : ROUND_NUMBER;
    const double above = (std::floor((has + extra) / multiple) + 1) * multiple - has;
    const double below = std::max(0.0, above - multiple);
    const double chance = double(hashOf(i) >> 11) * 0x1p-53;
    pixels[i].extra = static_cast<uint32_t>(chance * (above - below) < extra - below ? above : below);
  }
}

std::vector<SampleAllocation::Need> SampleAllocation::needs() const {
  const uint64_t pilots = pixels[0].pilots; // equal for all pixels
  const double n = double(pilots), paired = double(pilots / (2 * BLOCK) * (2 * BLOCK));
  // Relative to squared brightness: variance of samples, its root, and variance of blocks of samples.
  std::vector<double> brightness(pixels.size()), variance(pixels.size()), deviation(pixels.size()),
      blockVariance(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    const Pixel& p = pixels[i];
    const double luminance = p.luminance / n;
    brightness[i] = luminance * luminance + dark * dark;
    if (!(brightness[i] > 0)) continue;
    variance[i] = std::max(0.0, (p.luminanceSquared - p.luminance * luminance) / (n - 1)) / brightness[i];
    deviation[i] = std::sqrt(variance[i]);
    blockVariance[i] = p.differencesSquared / paired / brightness[i];
  }
  std::vector<Need> out(pixels.size());
  std::vector<double> key(pixels.size());
  for (size_t number = 0; number < Quarter::COUNT; ++number) {
    const Quarter quarter{number, width};
    const AreaSums counts(zeroIn(quarter, std::vector<double>(pixels.size(), 1)), width, height);
    const MeansOfOthers variances(quarter, counts, variance, width, height),
        deviations(quarter, counts, deviation, width, height);
    parallelFor(height, [&](size_t y) {
      for (size_t i = y * width; i < (y + 1) * width; ++i) {
        // Means of deviations limit the influence of a single bright sample.
        const double near =
            square((deviations.around(i, INNER_REACH) + deviations.around(i, OUTER_REACH)) / 2);
        // Rare bright samples among few pilots say nothing about the pixel that got them: all pixels around
        // expect an equal part of their variance.
        const double rare =
            std::max(0.0, variances.around(i, WIDE) - EVEN_SPREAD * square(deviations.around(i, WIDE)));
        key[i] = std::round((near + RARE_WEIGHT * rare) / MIN_STEP) * MIN_STEP;
      }
    });
    const ClassMeans expected(quarter, key, mapPerSample ? variance : blockVariance);
    for (size_t i = 0; i < pixels.size(); ++i)
      if (quarter.has(i))
        out[i].all = out[i].eye = std::pow(expected.at(key[i]), mapPerSample ? 0.5 : 1 / (1 + FALL));
  }
  if (mapPerSample) tellMapsApart(out, variance, brightness);
  return out;
}

void SampleAllocation::tellMapsApart(std::vector<Need>& needs, const std::vector<double>& variance,
                                     const std::vector<double>& brightness) const {
  const double n = double(pixels[0].pilots);
  // For horizontal pixel pairs: mean variance; half the variance of the difference is the camera-path part.
  std::vector<double> both(pixels.size()), difference(pixels.size());
  for (size_t i = 0; i + 1 < pixels.size(); ++i) {
    if (i % width % 2 != 0 || i % width + 1 == width) continue;
    const Pixel &p = pixels[i], &q = pixels[i + 1];
    const double scale = (brightness[i] + brightness[i + 1]) / 2;
    if (!(scale > 0)) continue;
    const double shared = (q.pair - p.luminance * q.luminance / n) / (n - 1) / scale;
    both[i] = both[i + 1] = (variance[i] * brightness[i] + variance[i + 1] * brightness[i + 1]) / 2 / scale;
    difference[i] = difference[i + 1] = std::max(0.0, both[i] - shared);
  }
  const AreaSums pairVariances(both, width, height), pairDifferences(difference, width, height);
  parallelFor(height, [&](size_t y) {
    for (size_t x = 0; x < width; ++x) {
      const size_t i = y * width + x, left = x / 2 * 2;
      // The pixel's own pair is excluded.
      const PixelSquare around(i, PAIRS, width, height);
      const Range ownX(left, std::min(left + 2, width)), ownY(y, y + 1);
      const auto partOf = [&](const AreaSums& sums) {
        return std::max(0.0, sums.sum(around.x, around.y) - sums.sum(ownX.within(around.x), ownY));
      };
      const double whole = partOf(pairVariances);
      if (whole > 0) needs[i].eye *= std::sqrt(std::min(1.0, partOf(pairDifferences) / whole));
    }
  });
  // Neighbours share photons, so that an estimate from few passes has an error common to its surroundings:
  // the photon variance is averaged over the picture.
  double photons = 0;
  for (const Need& need : needs) photons += square(need.all) - square(need.eye);
  photons = std::max(0.0, photons / double(needs.size()));
  // Camera paths are stratified: after n samples a variance e becomes less than e / n. A fall as n^-1.5,
  // the rate at edges, is assumed: underestimating e costs less than too few photon maps.
  const double stratified = 1 / std::sqrt(double(stage.end));
  for (Need& need : needs) {
    need.eye *= std::sqrt(stratified);
    need.all = std::sqrt(square(need.eye) + photons);
  }
}

} // namespace recurse
