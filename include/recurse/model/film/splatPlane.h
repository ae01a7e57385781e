/** @file
 * Contributions that fall on any pixel: what light paths bring to the eye.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "recurse/core/math/rgb.h"
#include "recurse/core/math/wideSum.h"
#include "recurse/model/camera/camera.h"

namespace recurse {

/**
 * For each pixel and layer a sum of contributions and the number of light paths that it is the sum of; for
 * each pixel the sums of luminance and of its square, which tell the variance. Sums are 128-bit fixed-point
 * numbers, so that threads may add in any order and the result is the same bits. What is smaller than the
 * unit is rounded at random, by a hash of the contribution, and stays right in the mean.
 */
class SplatPlane {
 public:
  /** `unit`: of the sums, a power of two. */
  SplatPlane(const PixelBounds& bounds, size_t layers, double unit)
      : bounds(bounds), layers(layers), unitOfSums(unit), sums(bounds.area() * layers * 3),
        moments(bounds.area()) {}

  /** Adds to each layer of the bit set, around a place of the film in pixels of the whole film. `value`:
   * finite, for one light path of a picture of one pixel's importance (WiSample). Any thread, any time. */
  void add(const Vec2f& film, const Filter& filter, uint64_t layerSet, const Rgb& value);
  /** Counts light paths, whether they brought something or not. Any thread. */
  void addPaths(uint64_t count);
  /** Adds what another plane of the same pixels, layers and unit has. */
  void add(const SplatPlane& other);
  void clear();

  /** The mean over light paths; black before the first. */
  Rgb value(size_t pixel, size_t layer) const;
  /** The mean over light paths of the luminance of all layers together, each contribution counted once. */
  double luminance(size_t pixel) const;
  /** Variance of luminance(), from the spread of the contributions: those of one light path to the same pixel
   * count as independent. Zero before the second path. */
  double variance(size_t pixel) const;
  double unit() const { return unitOfSums; }
  uint64_t paths() const { return figures.paths; }
  /** Contributions that were too large for the unit, and lost light by it. */
  uint64_t saturated() const { return figures.saturated; }
  /** The pass after the last one whose light paths are in it; to be known when a render goes on. */
  uint64_t nextPass() const { return figures.nextPass; }
  void setNextPass(uint64_t pass) { figures.nextPass = pass; }

  /** The numbers that it consists of, as they lie in memory. */
  std::array<std::span<std::byte>, 3> state() {
    return {std::as_writable_bytes(std::span(sums)), std::as_writable_bytes(std::span(moments)),
            std::as_writable_bytes(std::span(&figures, 1))};
  }
  /** Add the sums, and the last part, of other planes' state(); as Film::StatePart has it. */
  static void addSums(const void* from, void* into, size_t count);
  static void addFigures(const void* from, void* into, size_t count);
  /** Bytes of state(). */
  static double bytes(double pixels, double layers) {
    return pixels * (layers * 3 * sizeof(WideSum) + sizeof(Moments)) + sizeof(Figures);
  }

 private:
  struct Figures {
    uint64_t paths = 0, saturated = 0, nextPass = 0;
    void add(const Figures& o) {
      paths += o.paths;
      saturated += o.saturated;
      nextPass = std::max(nextPass, o.nextPass);
    }
  };
  /** Of a pixel, the first in the unit of sums and the second in that unit's square times SQUARE_SCALE. */
  struct Moments {
    WideSum luminance, square;
  };
  /** `largest`: of the absolute value; beyond, it counts as saturated. */
  void addTo(WideSum& sum, double units, double largest, uint64_t key);
  void addAll(WideSum& sum, const WideSum& other);

  PixelBounds bounds;
  size_t layers;
  double unitOfSums;
  std::vector<WideSum> sums;
  std::vector<Moments> moments;
  Figures figures;
};

} // namespace recurse
