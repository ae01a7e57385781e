/** @file
 * Independent uniform random numbers.
 */
#include "recurse/model/camera/pixelSampler.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class IndependentSampler final : public PixelSampler, public SamplePoints {
 public:
  IndependentSampler() : PixelSampler(true) {}
  Sampler samplerOfPoints(const PixelSample& s) const override {
    return {*this, hashCombine(hashCombine(mixBits(s.seed), s.pixel()), s.index), 0};
  }
  uint32_t strata(uint32_t, uint32_t) const override { return 1; }

  void fill(uint64_t key, uint32_t, uint32_t first, float* numbers) const override {
    for (uint32_t i = 0; i < PAIRS; ++i) {
      const uint64_t hash = pairHash(key, first + i);
      numbers[i] = unitFloat(static_cast<uint32_t>(hash >> 32));
      numbers[PAIRS + i] = unitFloat(static_cast<uint32_t>(hash));
    }
  }
};

} // namespace

void registerIndependentSampler(PlugIns& plugIns) {
  plugIns.samplers.add({{.name = "independent",
                         .summary = "Independent uniform random numbers.",
                         .parameters = pixelSamplerParameters(),
                         .examples = {""}},
                        [](const Parameters& p, const NoContext&) {
                          return withPixelSamples(std::make_unique<IndependentSampler>(), p);
                        }});
}

} // namespace recurse
