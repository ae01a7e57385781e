/** @file
 * Which of two estimators errs less for its work, by samples of a few blocks of the picture.
 */
#pragma once

#include <array>
#include <vector>

#include "recurse/transport/integrator/integrator.h"

namespace recurse {

/** Luminances of trial samples, one for each pixel of the blocks, and what they took. Lamps themselves are
 * left out, seen straight or by mirrors and glass: what their edges err by is the same for all, and would
 * hide what other light errs by. */
struct TrialSamples {
  std::vector<float> luminance;
  TransportCounts counts;
};

/** Blocks of 8 x 8 pixels all over the picture. */
class EstimatorTrial {
 public:
  static constexpr int BLOCK = 8;   ///< pixels, across
  static constexpr int BLOCKS = 12; ///< of the picture, across
  static constexpr int PIXELS = BLOCK * BLOCK * BLOCKS * BLOCKS;

  /** The scene and the classes must outlive it. `time` is that of all camera rays. */
  EstimatorTrial(const Scene& scene, const PathClasses& classes, uint64_t seed, float time)
      : scene(scene), classes(classes), seed(seed), time(time) {}

  /** One sample of each pixel; of another `round`, independent ones. */
  TrialSamples take(const Integrator& integrator, uint32_t round) const;

  /** What a sample of a pixel errs by and takes. */
  struct Figures {
    double ofPixels = 0; ///< relative variance
    double ofBlocks =
        0; ///< the same of means of blocks: less by their number of pixels, if those err independently
    double work = 0; ///< [rays of a camera path], by counts, so that it is the same on any machine

    /** Adds variance that pixels do not share. */
    void add(double variance);
    /** How much larger its errors are at equal work: the geometric mean over both scales. */
    double errorOver(const Figures& other) const;
  };
  /** Of an estimator, by two rounds whose samples have nothing in common, not even photons. `others` tell of
   * the same picture, by the same camera rays: where both are bright, the picture is. */
  using Rounds = std::array<TrialSamples, 2>;
  static Figures figures(const Rounds& own, const Rounds& others);
  /** By how many samples the light comes, (sum x)² / sum x² (Kish 1965, "Survey Sampling"): where they are
   * few, what they err by is not known. */
  static double effectiveCount(const Rounds& rounds);
  /** The relative variance, at least, of an unbiased estimator's pixels by light that `others` found and none
   * of its own samples did: it comes in samples rarer than these are many. */
  static double missedVariance(const Rounds& own, const Rounds& others);

 private:
  const Scene& scene;
  const PathClasses& classes;
  uint64_t seed;
  float time;
};

} // namespace recurse
