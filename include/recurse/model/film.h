/** @file
 * The film: for each pixel and layer the sum of its samples in double precision, and what the error estimate
 * needs. Integrators do not see it; they fill a PathRadiance, which knows the layers.
 */
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "recurse/core/rgb.h"
#include "recurse/model/camera.h"

namespace recurse {

class Film {
 public:
  Film(const PixelBounds& bounds, size_t layers)
      : pixelBounds(bounds), layers(layers), sums(bounds.area() * layers), pixels(bounds.area()) {}

  const PixelBounds& bounds() const { return pixelBounds; }
  size_t layerCount() const { return layers; }

  /** Adds a sample to a pixel: `values` has one colour a layer, `total` their sum without double counting.
   * Calls for different pixels may run at the same time. */
  void add(size_t pixel, float weight, const Rgb* values, const Rgb& total) {
    Rgbd* sum = &sums[pixel * layers];
    for (size_t i = 0; i < layers; ++i) sum[i] += Rgbd(values[i]) * double(weight);
    Pixel& p = pixels[pixel];
    p.weight += weight;
    const double y = double(luminance(total));
    p.luminance += y;
    p.luminanceSquared += y * y;
    ++p.samples;
  }

  /** Adds all samples of another film of the same pixels and layers. */
  void add(const Film& other);
  /** The numbers that the film consists of, as they lie in memory, to be kept and put back. */
  std::array<std::span<std::byte>, 2> state() {
    return {std::as_writable_bytes(std::span(sums)), std::as_writable_bytes(std::span(pixels))};
  }

  /** The pixel's value in a layer; black before the first sample. */
  Rgb value(size_t pixel, size_t layer) const {
    const double weight = pixels[pixel].weight;
    return weight != 0 ? Rgb(sums[pixel * layers + layer] / weight) : BLACK;
  }
  uint64_t samples(size_t pixel) const { return pixels[pixel].samples; }
  uint64_t totalSamples() const {
    uint64_t n = 0;
    for (const Pixel& p : pixels) n += p.samples;
    return n;
  }
  /** Variance of the samples' luminance at a pixel; zero before the second sample. */
  double variance(size_t pixel) const {
    const Pixel& p = pixels[pixel];
    if (p.samples < 2) return 0;
    const double n = double(p.samples);
    return std::max(0.0, (p.luminanceSquared - p.luminance * p.luminance / n) / (n - 1));
  }

  /** Standard error of a pixel's luminance, from the spread of its samples. Samples of a pixel are
   * stratified, so that the true error is smaller rather than larger; what all samples share, such as one
   * photon map, is not in it. */
  double standardError(size_t pixel) const {
    return pixels[pixel].samples > 0 ? std::sqrt(variance(pixel) / double(pixels[pixel].samples)) : 0;
  }
  /**
   * One number for the picture: the 95th percentile over pixels of standard error divided by luminance, where
   * the luminance counts as no less than a tenth of the picture's mean, for in black corners a relative error
   * says nothing that the eye could see. Infinite while a pixel has fewer than LEAST_SAMPLES samples, from
   * which no spread can be told.
   */
  double relativeError() const;
  static constexpr uint64_t LEAST_SAMPLES = 8;

 private:
  struct Pixel {
    double weight = 0, luminance = 0, luminanceSquared = 0;
    uint64_t samples = 0;
  };
  PixelBounds pixelBounds;
  size_t layers;
  std::vector<Rgbd> sums;
  std::vector<Pixel> pixels;
};

} // namespace recurse
