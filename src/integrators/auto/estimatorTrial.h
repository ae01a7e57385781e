/** @file
 * Comparison of the efficiency of two estimators, by samples of a few blocks of the image.
 */
#pragma once

#include <array>
#include <vector>

#include "recurse/transport/integrator/integrator.h"

namespace recurse {

/** Luminances of trial samples, one for each pixel of the blocks, and their counts. Light from light sources
 * that are visible directly or through mirrors and glass is omitted: errors at their edges are equal for all
 * estimators, and would hide the errors of other light. */
struct TrialSamples {
  std::vector<float> luminance;
  TransportCounts counts;
};

/** Trial on blocks of 8 x 8 pixels, distributed over the image. */
class EstimatorTrial {
 public:
  static constexpr int BLOCK = 8;   ///< width of a block [pixels]
  static constexpr int BLOCKS = 12; ///< blocks along each axis of the image
  static constexpr int PIXELS = BLOCK * BLOCK * BLOCKS * BLOCKS;

  /** The scene and the classes must outlive the trial. All camera rays have the given `time`. */
  EstimatorTrial(const Scene& scene, const PathClasses& classes, uint64_t seed, float time)
      : scene(scene), classes(classes), seed(seed), time(time) {}

  /** Takes one sample of each pixel. Samples of different rounds are independent. */
  TrialSamples take(const Integrator& integrator, uint32_t round) const;

  /** Relative variance and work of one sample for each pixel. */
  struct Figures {
    double ofPixels = 0; ///< relative variance of pixels
    /** Relative variance of block means; equals ofPixels / pixels per block if pixels are independent. */
    double ofBlocks = 0;
    double work = 0; ///< cost per pixel [camera rays], from counters, not clocks

    /** Adds relative variance that is independent between pixels. */
    void add(double variance);
    /** Ratio of the variances at equal work: geometric mean over pixels and blocks. */
    double errorOver(const Figures& other) const;
  };
  /** Figures of an estimator from two independent rounds, which do not share photons either. `others`: rounds
   * of the competing estimator with the same camera rays; pixels that are bright in both count as bright. */
  using Rounds = std::array<TrialSamples, 2>;
  static Figures figures(const Rounds& rounds, const Rounds& others);
  /** Effective number of samples that carry the light, (sum x)² / sum x² (Kish 1965, "Survey Sampling"). If
   * it is small, the variance is unknown. */
  static double effectiveCount(const Rounds& rounds);
  /** Lower bound of the relative variance of an unbiased estimator's pixels, from light that `others` found
   * and its own samples missed: such samples are rarer than one among all of them. */
  static double missedVariance(const Rounds& rounds, const Rounds& others);

 private:
  const Scene& scene;
  const PathClasses& classes;
  uint64_t seed;
  float time;
};

} // namespace recurse
