/** @file
 * Plane of splats: contributions of light paths to any pixel.
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
 * Sum of contributions for each pixel and layer with the common number of light paths, and for each pixel the
 * sums of luminance and squared luminance for the variance. Sums are 128-bit fixed-point numbers, so that
 * threads may add in any order with bit-identical results. Fractions of the unit are rounded at random, by a
 * hash of the contribution, without bias. Indices of pixels are row by row within the bounds, and not
 * checked.
 */
class SplatPlane {
 public:
  /** `unit`: resolution of the sums, a power of two. */
  SplatPlane(const PixelBounds& bounds, size_t layers, double unit)
      : bounds(bounds), layers(layers), unitOfSums(unit), sums(bounds.area() * layers * 3),
        moments(bounds.area()) {}

  /** Adds value times filter to each layer of the bit set, in the pixels around a point [pixels of the whole
   * film]. `value` is finite: the contribution of one light path for the importance of one pixel (WiSample).
   * `extraLayer`: another layer, of any index. Callable from any thread, but not while sums are read. */
  void add(const Vec2f& film, const Filter& filter, uint64_t layerSet, const Rgb& value,
           size_t extraLayer = NO_LAYER);
  static constexpr size_t NO_LAYER = SIZE_MAX;
  /** Counts light paths, with or without contributions. Callable from any thread. */
  void addPaths(uint64_t count);
  /** Adds the sums of a plane with the same pixels, layers and unit. */
  void add(const SplatPlane& other);
  void clear();

  /** Mean over light paths; black before the first. */
  Rgb value(size_t pixel, size_t layer) const;
  /** Mean over light paths of the luminance of all layers together, each contribution counted once. */
  double luminance(size_t pixel) const;
  /** Variance of luminance() from the sums of squares. Contributions of one light path to the same pixel
   * count as independent. Zero before the second path. */
  double variance(size_t pixel) const;
  double unit() const { return unitOfSums; }
  uint64_t paths() const { return figures.paths; }
  /** Number of additions to one colour of one layer of a pixel that were clamped or overflowed, and to its
   * moments that overflowed: their light is lost in part. Additions by addSums() are not counted. */
  uint64_t saturated() const { return figures.saturated; }
  /** Number of the first pass whose light paths are not included; needed to resume a render. */
  uint64_t nextPass() const { return figures.nextPass; }
  void setNextPass(uint64_t pass) { figures.nextPass = pass; }

  /** Memory blocks with the whole content of the plane. */
  std::array<std::span<std::byte>, 3> state() {
    return {std::as_writable_bytes(std::span(sums)), std::as_writable_bytes(std::span(moments)),
            std::as_writable_bytes(std::span(&figures, 1))};
  }
  /** Film::StatePart::Add for the elements of state(): `count` WideSums, or `count` last blocks. */
  static void addSums(const void* from, void* into, size_t count);
  static void addFigures(const void* from, void* into, size_t count);
  /** Size of state() [bytes]. */
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
  /** Moments of a pixel: luminance in the unit of sums, square in its square times SQUARE_SCALE. */
  struct Moments {
    WideSum luminance, square;
  };
  /** `largest`: maximum absolute value, beyond which a contribution is saturated. */
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
