/** @file
 * Rounds of a process that renders alone, and the order of tiles.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>

#include "recurse/render/renderSettings.h"

namespace recurse {

/** Lengths of rounds, in each of which all pixels get equally many samples, within the remaining time. */
class RoundSchedule {
 public:
  /** Largest number of samples in a round. */
  static constexpr int64_t LONGEST_ROUND = 64;

  /** `first`: index of the first sample. */
  explicit RoundSchedule(int64_t first) : first(first) {}

  /** Samples of the round from `sample` on that end within `timeLeft` [s]; 0: not even one. */
  int64_t roundLength(int64_t sample, double timeLeft) const {
    const int64_t longest = std::clamp<int64_t>(sample - first, 1, LONGEST_ROUND);
    if (sampleSeconds <= 0 || std::isinf(timeLeft)) return longest;
    if (timeLeft < sampleSeconds) return 0;
    return std::clamp<int64_t>(int64_t(timeLeft / sampleSeconds / 2), 1, longest);
  }
  void addRound(int64_t samples, double seconds) { sampleSeconds = seconds / double(samples); }

  /** True if one more photon map can be finished in `timeLeft` [s]: a part of a map cannot be used. */
  bool isPassInTime(double timeLeft) const { return passes == 0 || passSeconds / passes <= timeLeft; }
  /** Adds the time of a photon map [s], except for the first, which includes learning. */
  void addPass(double seconds) {
    passSeconds += seconds;
    ++passes;
  }

 private:
  int64_t first;
  double sampleSeconds = 0; ///< time of one sample of each pixel in the latest round
  double passSeconds = 0;
  int passes = 0;
};

/** Stages of the first sample under a time limit: a lattice of pixels, a finer one, the remainder. If the
 * time ends between two stages, the picture is coarse instead of half black. */
struct CoarseToFine {
  static constexpr int STAGES = 3, SPACING = 4;
  static constexpr int stageOf(int x, int y) {
    return x % SPACING == 0 && y % SPACING == 0               ? 0
           : x % (SPACING / 2) == 0 && y % (SPACING / 2) == 0 ? 1
                                                              : 2;
  }
};
static_assert(FIRST_SAMPLE_REACH == 2 * (CoarseToFine::SPACING - 1)); // in a corner of the picture

/** Order of tiles without rows or columns, so that an abandoned round leaves no visible band. */
class ScatteredOrder {
 public:
  explicit ScatteredOrder(size_t count) : count(count), step(std::max<size_t>(1, count * 5 / 8)) {
    while (std::gcd(step, count) != 1) ++step;
  }
  size_t operator[](size_t i) const { return i * step % count; }

 private:
  size_t count, step;
};

} // namespace recurse
