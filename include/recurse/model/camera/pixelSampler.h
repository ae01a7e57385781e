/** @file
 * Samplers: the points of the samples of pixels.
 */
#pragma once

#include <memory>

#include "recurse/core/sampling/sampler.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Position of a sample. */
struct PixelSample {
  uint64_t seed = 0;      ///< seed of the render: PixelSampler::seed unless an option replaces it
  uint32_t x = 0, y = 0;  ///< pixel of the whole film, so that a crop has the same samples
  uint32_t index = 0;     ///< number of the sample within its pixel
  uint32_t requested = 1; ///< samples of each pixel as planned; `index` may exceed it

  /** Number of the pixel, the same for films of any size. */
  uint64_t pixel() const { return uint64_t(y) << 32 | x; }
};

/** Plug-in of the directive Sampler. Photons and light paths, which belong to no pixel, have the Sobol'
 * points of Sampler. */
class PixelSampler {
 public:
  virtual ~PixelSampler() = default;

  /** Numbers of a sample, which depend only on the argument and on the parameters. This object must outlive
   * the result. Any thread may call it. */
  Sampler sampler(const PixelSample& sample) const {
    // The default without a virtual call.
    return hasPoints ? samplerOfPoints(sample) : Sampler(sample.seed, sample.pixel(), sample.index);
  }
  /** Number n of intervals [i/n, (i + 1)/n) of a dimension with equally many of the first `samples` > 0
   * samples of a pixel, where PixelSample::requested is `samples`; 1: no stratification. `dimension`: 2 ·
   * pair + axis, each from 0. */
  virtual uint32_t strata(uint32_t dimension, uint32_t samples) const = 0;
  /** Whether the samples of different pixels are independent. */
  virtual bool hasIndependentPixels() const { return true; }

  int pixelSamples = 16; ///< samples of each pixel
  uint64_t seed = 0;

 protected:
  /** `hasPoints`: true: samplerOfPoints() is overridden; false: the Sobol' points of Sampler. */
  explicit PixelSampler(bool hasPoints) : hasPoints(hasPoints) {}
  /** sampler() of points other than those of Sampler. */
  virtual Sampler samplerOfPoints(const PixelSample& sample) const {
    return {sample.seed, sample.pixel(), sample.index};
  }

 private:
  bool hasPoints;
};

/** Parameters "pixelsamples" and "seed", and `more`. */
std::vector<ParameterSpec> pixelSamplerParameters(std::vector<ParameterSpec> more = {});
/** Parameter "seed". */
ParameterSpec samplerSeedParameter();
/** Returns `sampler` with the values of the parameters of pixelSamplerParameters(). */
std::unique_ptr<PixelSampler> withPixelSamples(std::unique_ptr<PixelSampler> sampler, const Parameters& p);

/** Largest power of `base` that divides `number` > 0. */
constexpr uint32_t largestPowerDividing(uint32_t number, uint32_t base) {
  uint32_t power = 1;
  for (; number % base == 0; number /= base) power *= base;
  return power;
}

} // namespace recurse
