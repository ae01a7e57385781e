/** @file
 * Adaptive samples: how many samples each pixel of a picture gets, so that the error of the whole becomes
 * least (Neyman 1934, "On the Two Different Aspects of the Representative Method"):
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

class SampleAllocation {
  struct Stage {
    int64_t first = 0, end = 0; ///< samples of the average pixel
    uint64_t seed = 0;
  };
  struct Pixel {
    double luminance = 0, luminanceSquared = 0; ///< of pilot samples
    /** Of a pair of blocks, the sum of the first less that of the second: so far in the latest, and its
     * square over all that are complete. */
    double difference = 0, differencesSquared = 0;
    /** With a map for each pass: in columns of even number the latest pilot sample, in those after them the
     * sum of products of both's. */
    double pair = 0;
    uint64_t pilots = 0; ///< that were taken
    uint32_t before = 0; ///< samples when the stage began
    uint32_t extra = 0;  ///< samples in the stage beside pilot samples
  };

 public:
  /** So many samples of each pixel come first. */
  static constexpr int64_t EVEN = int64_t(Film::MIN_SAMPLES);
  static constexpr int64_t PILOT_PERIOD = 4;
  static constexpr double MAX_SHARE = 8;
  /** Pilot samples that are taken together. */
  static constexpr int64_t BLOCK = 4;
  /** Between that of noise, 1, and that of edges, 1.5. */
  static constexpr double FALL = 1.4;
  static constexpr size_t MIN_CLASS = 64;
  /** Samples of each pixel on average from one look at the errors to the next, at most; before that it is as
   * many as there have been. */
  static constexpr int64_t LONGEST_STAGE = 64;
  /** Pilot samples of a pixel in a stage, at most. */
  static constexpr size_t MAX_PILOTS = std::max(EVEN, LONGEST_STAGE / PILOT_PERIOD);

  /** `imagingRatio`: of the picture to the film. */
  explicit SampleAllocation(const PixelBounds& bounds, double imagingRatio = 1)
      : width(size_t(bounds.width())), height(size_t(bounds.height())), dark(0.1 / imagingRatio),
        pixels(bounds.area()), stagePilots(bounds.area() * MAX_PILOTS) {}

  /** Where the stage ends that sample number `sample` of the average pixel is in. */
  static int64_t stageEnd(int64_t sample);
  /** Where the stage ends that was dealt out last; 0: none was. */
  int64_t dealtUpTo() const { return stage.end; }
  /** Deals out the stage from `sample` up to `end`, unless that has been done. All pixels must have what was
   * due before. */
  void begin(int64_t sample, int64_t end, uint64_t seed);
  /** Call before the first sample: each sample of the average pixel has a photon map of its own. */
  void setMapPerSample(bool is) { mapPerSample = is; }

  /** How many samples of a pixel there are to be when the average pixel has `sample`, within the stage. */
  uint64_t due(size_t pixel, int64_t sample) const;
  /** Pilot samples of each pixel in the stage when the average pixel has `sample`. */
  uint64_t pilotsDue(int64_t sample) const { return uint64_t(pilots(stage.first, sample)); }
  /** How many of them the pixel has had. */
  uint64_t pilotsDone(size_t pixel) const {
    return pixels[pixel].pilots - std::min(pixels[pixel].pilots, uint64_t(pilotsUpTo(stage.first)));
  }
  /** Tells of pilot sample `number` of the stage, in any order; any thread, for different pixels. */
  void addPilot(size_t pixel, size_t number, float luminance) {
    stagePilots[pixel * MAX_PILOTS + number] = luminance;
    ++pixels[pixel].pilots;
  }
  /** Pilot samples [first, end) of the stage of a pixel, for those who add them up elsewhere. */
  std::span<float> pilotsOf(size_t pixel, size_t first, size_t end) {
    return std::span(stagePilots).subspan(pixel * MAX_PILOTS + first, end - first);
  }

  /** What it takes in memory, and of state(), for so many pixels. */
  static double bytes(double pixels) {
    return sizeof(Stage) + (sizeof(Pixel) + MAX_PILOTS * sizeof(float)) * pixels;
  }
  /** The numbers that it consists of, as they lie in memory, to be kept and put back. */
  std::array<std::span<std::byte>, 3> state() {
    return {std::as_writable_bytes(std::span(&stage, 1)), std::as_writable_bytes(std::span(pixels)),
            std::as_writable_bytes(std::span(stagePilots))};
  }
  /** What due() and pilotsDue() depend on, for another process that renders a part of the stage. */
  std::vector<std::byte> plan() const;
  void setPlan(std::span<const std::byte> plan);

 private:
  /** What a pixel gets samples in proportion to. */
  struct Need {
    double all = 0;
    double eye = 0; ///< the part of the camera paths; the same without a map for each sample
  };
  /** Pilot samples of each pixel among those of the stage that come before `sample` and from `from` on. */
  int64_t pilots(int64_t from, int64_t sample) const;
  /** Pilot samples of each pixel when the average one has `sample`, at the end of a stage. */
  int64_t pilotsUpTo(int64_t sample) const;
  /** Adds the stage's pilot samples to what is known of the pixels. */
  void addStagePilots();
  std::vector<Need> needs() const;
  void tellMapsApart(std::vector<Need>& needs, const std::vector<double>& variance,
                     const std::vector<double>& brightness) const;
  uint64_t hashOf(size_t pixel) const;

  size_t width, height;
  double dark; ///< luminance
  bool mapPerSample = false;
  Stage stage;
  std::vector<Pixel> pixels;
  std::vector<float> stagePilots; ///< luminances, MAX_PILOTS of each pixel
};

} // namespace recurse
