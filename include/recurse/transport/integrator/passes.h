/** @file
 * Schedule of forward passes in a render: their number, and the samples of each.
 */
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace recurse {

/** Distribution of samples among passes. */
enum class PassSchedule {
  ONE_MAP,   ///< one pass for all samples
  FIXED,     ///< a given number of passes, each for an equal part of the samples
  DOUBLING,  ///< as many samples as in all passes before; one sample in the first and the second
  PER_SAMPLE ///< a pass for each sample of all pixels
};

/** The passes of a render, numbered from 0. */
class Passes {
 public:
  static Passes oneMap() { return {PassSchedule::ONE_MAP, 1}; }
  /** Schedule of `count` > 0 passes. One pass is oneMap(). */
  static Passes fixed(int64_t count) {
    return {count == 1 ? PassSchedule::ONE_MAP : PassSchedule::FIXED, count};
  }
  static Passes doubling() { return {PassSchedule::DOUBLING, 1}; }
  static Passes perSample() { return {PassSchedule::PER_SAMPLE, 1}; }

  PassSchedule schedule() const { return kind; }
  /** Minimum number of samples of each pixel in a render. */
  int64_t minSamples() const { return count; }
  /** First sample of a pass, out of `samples` of each pixel; may be above `samples` for the pass after the
   * last. */
  int64_t begin(int64_t pass, int64_t samples) const {
    if (kind == PassSchedule::PER_SAMPLE) return pass;
    if (kind == PassSchedule::DOUBLING) return pass == 0 ? 0 : int64_t(1) << std::min<int64_t>(pass - 1, 62);
    return pass * samples / count;
  }
  /** Pass of a sample. */
  int64_t of(int64_t sample, int64_t samples) const {
    if (kind == PassSchedule::PER_SAMPLE) return sample;
    if (kind == PassSchedule::DOUBLING) return std::bit_width(static_cast<uint64_t>(sample));
    int64_t pass = sample * count / samples;
    while (begin(pass + 1, samples) <= sample) ++pass;
    return pass;
  }

 private:
  Passes(PassSchedule kind, int64_t count) : kind(kind), count(count) {}
  PassSchedule kind;
  int64_t count; ///< 1 for DOUBLING and PER_SAMPLE
};

} // namespace recurse
