/** @file
 * Adaptive sampling: number of samples of each pixel that minimises the error of the picture (Neyman
 * 1934, "On the Two Different Aspects of the Representative Method"):
 * doc-files/notes/adaptive-samples.md.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "recurse/model/film/film.h"

namespace recurse {

/** Allocation of adaptive samples in stages. Pilot samples, equally many for each pixel, estimate the
 * variance by which the next stage is allocated. Pixels have the indices of the Film with the same bounds. */
class SampleAllocation {
  struct Stage {
    int64_t first = 0, end = 0; ///< samples of the average pixel
    uint64_t seed = 0;
  };
  struct Pixel {
    double luminance = 0, luminanceSquared = 0; ///< sums over pilot samples
    /** Sum of a block of pilot samples minus the sum of the next one: up to now in the current pair of
     * blocks, and its square summed over all complete pairs. */
    double difference = 0, differencesSquared = 0;
    /** With a map per sample: in even columns the latest pilot sample; in odd columns the sum of products of
     * the pilot samples of both pixels. */
    double pair = 0;
    uint64_t pilots = 0; ///< number of pilot samples taken
    uint32_t before = 0; ///< samples at the beginning of the stage
    uint32_t extra = 0;  ///< samples in the stage in addition to pilot samples
  };

 public:
  /** Number of initial samples, the same for each pixel. */
  static constexpr int64_t EVEN = int64_t(Film::MIN_SAMPLES);
  static constexpr int64_t PILOT_PERIOD = 4; ///< samples of the average pixel for a pilot sample, after EVEN
  static constexpr double MAX_SHARE = 8;     ///< maximum ratio to the samples of the average pixel
  /** Number of consecutive pilot samples in a sum: pairs of sums estimate variance. */
  static constexpr int64_t BLOCK = 4;
  /** Assumed exponent of the decrease of the squared error with samples: between noise, 1, and edges, 1.5. */
  static constexpr double FALL = 1.4;
  static constexpr size_t MIN_CLASS = 64; ///< minimum number of pixels that share a predicted variance
  /** Maximum length of a stage between two allocations [samples of the average pixel]; earlier stages double
   * the number of samples. */
  static constexpr int64_t LONGEST_STAGE = 64;
  /** Maximum number of pilot samples of a pixel in a stage. */
  static constexpr size_t MAX_PILOTS = std::max(EVEN, LONGEST_STAGE / PILOT_PERIOD);

  /** `imagingRatio`: factor from the film to the picture. */
  explicit SampleAllocation(const PixelBounds& bounds, double imagingRatio = 1)
      : width(size_t(bounds.width())), height(size_t(bounds.height())), dark(0.1 / imagingRatio),
        pixels(bounds.area()), stagePilots(bounds.area() * MAX_PILOTS) {}

  /** End of the stage that contains sample number `sample` of the average pixel. */
  static int64_t stageEnd(int64_t sample);
  /** Beginning of the stage allocated last; 0: none. */
  int64_t dealtFrom() const { return stage.first; }
  /** End of the stage allocated last; 0: none. */
  int64_t dealtUpTo() const { return stage.end; }
  /** Allocates the stage from `sample` up to `end`, at most stageEnd(sample), unless it is allocated already.
   * All pixels must have their samples of the stage before. `seed`: of the random rounding to whole
   * samples. */
  void begin(int64_t sample, int64_t end, uint64_t seed);
  /** Sets whether each sample of the average pixel has its own photon map; before the first sample. */
  void setMapPerSample(bool is) { mapPerSample = is; }

  /** Total number of samples due at a pixel when the average pixel has `sample`, within the stage. */
  uint64_t due(size_t pixel, int64_t sample) const;
  /** Number of pilot samples due at each pixel in the stage when the average pixel has `sample`. */
  uint64_t pilotsDue(int64_t sample) const { return uint64_t(pilots(stage.first, sample)); }
  /** Number of pilot samples in the stage that the pixel has had. */
  uint64_t pilotsDone(size_t pixel) const {
    return pixels[pixel].pilots - std::min(pixels[pixel].pilots, uint64_t(pilotsUpTo(stage.first)));
  }
  /** Sets pilot sample `number` of the stage, in any order; any thread, for different pixels. */
  void addPilot(size_t pixel, size_t number, float luminance) {
    stagePilots[pixel * MAX_PILOTS + number] = luminance;
    ++pixels[pixel].pilots;
  }
  /** Pilot samples [first, end) of the stage of a pixel, to be merged elsewhere. */
  std::span<float> pilotsOf(size_t pixel, size_t first, size_t end) {
    return std::span(stagePilots).subspan(pixel * MAX_PILOTS + first, end - first);
  }

  /** Memory of an allocation, which is also the size of state(), for this many pixels [bytes]. */
  static double bytes(double pixels) {
    return sizeof(Stage) + (sizeof(Pixel) + MAX_PILOTS * sizeof(float)) * pixels;
  }
  /** Memory blocks with the whole content, to be saved and restored. */
  std::array<std::span<std::byte>, 3> state() {
    return {std::as_writable_bytes(std::span(&stage, 1)), std::as_writable_bytes(std::span(pixels)),
            std::as_writable_bytes(std::span(stagePilots))};
  }
  /** Data on which due() and pilotsDue() depend besides setMapPerSample(), for processes that share it. */
  std::vector<std::byte> plan() const;
  /** Takes over the plan of an allocation for the same bounds. */
  void setPlan(std::span<const std::byte> plan);

 private:
  /** Weights of a pixel in proportion to which samples are allocated. */
  struct Need {
    double all = 0;
    double eye = 0; ///< from the noise of camera paths; the same as `all` without a map for each sample
  };
  /** Number of pilot samples of each pixel for samples [from, sample) of the stage. */
  int64_t pilots(int64_t from, int64_t sample) const;
  /** Number of pilot samples of each pixel when the average pixel has `sample`, the end of a stage. */
  int64_t pilotsUpTo(int64_t sample) const;
  /** Adds the pilot samples of the stage to the statistics of the pixels. */
  void addStagePilots();
  std::vector<Need> needs() const;
  /** Allocates the samples of the stage to a quarter of the pixels, whose needs follow from the other three.
   */
  void allocateQuarter(size_t number, const std::vector<Need>& need, int64_t sample, int64_t end);
  void tellMapsApart(std::vector<Need>& needs, const std::vector<double>& variance,
                     const std::vector<double>& brightness) const;
  uint64_t hashOf(size_t pixel) const;

  size_t width, height;
  double dark; ///< luminance below which an error counts as absolute rather than relative
  bool mapPerSample = false;
  Stage stage;
  std::vector<Pixel> pixels;
  std::vector<float> stagePilots; ///< luminances, MAX_PILOTS for each pixel
};

} // namespace recurse
