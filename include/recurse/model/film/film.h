/** @file
 * The film: for each pixel and layer the sum of its samples, bit-identical for any order of them, the
 * statistics of the error estimate, and the splats of light paths. Values are radiance [W/(m² sr)] after
 * white balance and before FilmSettings::imagingRatio. Indices of pixels are row by row within bounds(), and
 * not checked. Integrators have no access to it; they fill a PathRadiance or a Splatter, which handle the
 * layers.
 */
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "recurse/core/math/longSum.h"
#include "recurse/core/math/rgb.h"
#include "recurse/model/camera/camera.h"
#include "recurse/model/film/splatPlane.h"

namespace recurse {

class Film {
  struct Pixel {
    LongSum weight, luminance, luminanceSquared;
    LongSum halfLuminance; ///< of the samples in every second batch
    uint64_t samples = 0, halfSamples = 0;
    void add(const Pixel& o) {
      weight += o.weight;
      luminance += o.luminance;
      luminanceSquared += o.luminanceSquared;
      halfLuminance += o.halfLuminance;
      samples += o.samples;
      halfSamples += o.halfSamples;
    }
  };

 public:
  Film(const PixelBounds& bounds, size_t layers)
      : pixelBounds(bounds), layers(layers), sums(bounds.area() * layers * 3), pixels(bounds.area()) {}

  const PixelBounds& bounds() const { return pixelBounds; }
  size_t layerCount() const { return layers; }

  /** Adds sample `index` of a pixel with its filter weight: `values` has one finite colour for each layer,
   * `total` is their sum without double counting. Calls for different pixels may run at the same time. */
  template <class T>
  void add(size_t pixel, uint32_t index, float weight, const RgbOf<T>* values, const Rgb& total) {
    LongSum* sum = &sums[pixel * layers * 3];
    for (size_t i = 0; i < layers; ++i)
      for (int c = 0; c < 3; ++c) *sum++ += double(values[i][c]) * double(weight);
    Pixel& p = pixels[pixel];
    p.weight += double(weight);
    const double y = double(luminance(total));
    p.luminance += y;
    p.luminanceSquared += y * y;
    ++p.samples;
    if (index / BATCH % 2 == 0) return;
    p.halfLuminance += y;
    ++p.halfSamples;
  }

  /** Allocates the splat plane, unless it exists; sums are fixed-point with this unit, a power of two. */
  void enableSplats(double unit) {
    if (!splatPlane) splatPlane.emplace(pixelBounds, layers, unit);
  }
  /** Plane of splats, whose values are added to the mean of the samples; null unless enabled. */
  SplatPlane* splats() { return splatPlane ? &*splatPlane : nullptr; }
  const SplatPlane* splats() const { return splatPlane ? &*splatPlane : nullptr; }
  /** Adds a contribution around a point of the film to the layers of a bit set, after enableSplats(); see
   * SplatPlane::add(). */
  void splat(const Vec2f& film, const Filter& filter, uint64_t layerSet, const Rgb& value) {
    splatPlane->add(film, filter, layerSet, value);
  }

  /** Adds all samples and splats of a film with the same pixels, layers and unit of splats. */
  void add(const Film& other);
  /** Memory of the film, which is also the size of state(), without splats [bytes]. */
  static double bytes(double pixels, double layers) {
    return pixels * (layers * 3 * sizeof(LongSum) + sizeof(Pixel));
  }
  /** Memory blocks with the whole content of the film, to be saved and restored. */
  std::vector<std::span<std::byte>> state() {
    std::vector<std::span<std::byte>> parts{std::as_writable_bytes(std::span(sums)),
                                            std::as_writable_bytes(std::span(pixels))};
    if (splatPlane)
      for (const std::span<std::byte> part : splatPlane->state()) parts.push_back(part);
    return parts;
  }

  /** Block of state() as an array of additive elements. */
  struct StatePart {
    /** Adds `count` elements at `from` to as many at `into`, which do not overlap. */
    using Add = void (*)(const void* from, void* into, size_t count);
    std::span<std::byte> bytes;
    size_t elementBytes;
    Add add;
  };
  /** Blocks of state(), in the same order, for sums computed elsewhere. */
  std::vector<StatePart> stateParts();

  /** Value of a pixel in a layer: mean of its samples by filter weight, black before the first one, plus
   * splats. */
  Rgb value(size_t pixel, size_t layer) const {
    const double weight = pixels[pixel].weight;
    const LongSum* sum = &sums[(pixel * layers + layer) * 3];
    const Rgb mean = weight != 0 ? Rgb(Rgbd(sum[0], sum[1], sum[2]) / weight) : BLACK;
    return splatPlane ? mean + splatPlane->value(pixel, layer) : mean;
  }
  uint64_t samples(size_t pixel) const { return pixels[pixel].samples; }
  /** For each pixel the nearest one with samples, where that is no more than `reach` steps along rows and
   * columns away, else itself; empty: all have samples. */
  std::vector<size_t> nearestSampled(int reach) const;
  uint64_t totalSamples() const {
    uint64_t n = 0;
    for (const Pixel& p : pixels) n += p.samples;
    return n;
  }
  /** Luminance of a pixel: mean of its samples, all of weight 1, plus splats. */
  double luminanceOf(size_t pixel) const {
    const Pixel& p = pixels[pixel];
    return (p.samples > 0 ? p.luminance / double(p.samples) : 0) +
           (splatPlane ? splatPlane->luminance(pixel) : 0);
  }
  /** Variance of the luminance of a pixel's samples, without splats; zero before the second sample. */
  double variance(size_t pixel) const {
    const Pixel& p = pixels[pixel];
    if (p.samples < 2) return 0;
    const double n = double(p.samples);
    return std::max(0.0, (p.luminanceSquared - p.luminance * p.luminance / n) / (n - 1));
  }

  /**
   * Standard error of each pixel's luminance. Samples are stratified and pixels share photon passes, so the
   * sample variance gives the distribution of the error, not its scale. The scale is the difference of two
   * halves of the samples, each of whole batches of consecutive ones, averaged over neighbouring pixels.
   * Errors common to all samples, such as those from a single photon map, are not included. The variance of
   * splats is included; the variance of samples is zero before the second sample. The samples of a black
   * pixel have no spread, although light may only be hard to find: relative to a tenth of the image's mean,
   * its error is the root mean square of errors around it, each times the chance that such a pixel would be
   * black, relative to the mean luminance there.
   */
  std::vector<double> standardErrors() const;
  /**
   * Error of the whole image: 95th percentile over pixels of standard error over luminance, which counts
   * as at least a tenth of the image's mean. Black pixels count only near others. Infinite while a pixel has
   * fewer than MIN_SAMPLES samples, too few for a sample variance; 0 for a black image.
   */
  double relativeError() const;
  static constexpr uint64_t MIN_SAMPLES = 8;

 private:
  static constexpr uint32_t BATCH = 8; ///< samples; a power of two, like the strata of Sobol' points

  /** Chance that all samples of a pixel are black if each is with the same probability, and all others are
   * equal: by the mean and variance of its samples. */
  double chanceOfBlack(size_t pixel) const;
  /** Luminance below which relative errors are not visible: a tenth of the image's mean. */
  double darkLuminance() const;
  /** Variance of the mean of a pixel's samples from the difference of its halves; empty with one half. */
  std::optional<double> varianceByHalves(size_t pixel) const;

  PixelBounds pixelBounds;
  size_t layers;
  std::vector<LongSum> sums; ///< red, green and blue of each layer of each pixel
  std::vector<Pixel> pixels;
  std::optional<SplatPlane> splatPlane;
};

} // namespace recurse
