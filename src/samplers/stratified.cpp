/** @file
 * Stratified samples: multi-jittered (Chiu, Shirley and Wang, "Multi-Jittered Sampling", Graphics Gems IV,
 * 1994), so that both pairs and single dimensions are stratified.
 */
#include "recurse/core/sampling/permutation.h"
#include "recurse/model/camera/pixelSampler.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class StratifiedSampler final : public PixelSampler, public SamplePoints {
 public:
  StratifiedSampler(uint32_t across, uint32_t down, bool jitter)
      : PixelSampler(true), across(across), down(down), jitter(jitter) {}

  Sampler samplerOfPoints(const PixelSample& s) const override {
    // Every across · down samples are a set of their own.
    const uint32_t set = s.index / (across * down);
    return {*this, hashCombine(hashCombine(mixBits(s.seed), s.pixel()), set), s.index % (across * down)};
  }
  uint32_t strata(uint32_t, uint32_t samples) const override {
    return samples % (across * down) == 0 ? across * down : 1;
  }

  void fill(uint64_t key, uint32_t index, uint32_t first, float* numbers) const override {
    for (uint32_t i = 0; i < PAIRS; ++i) {
      const uint64_t hash = pairHash(key, first + i);
      const uint32_t cell = permutedElement(index, across * down, hash);
      const uint32_t column = cell % across, row = cell / across;
      // Within its cell, a sample is in one of `down` columns or `across` rows that no sample of the same
      // column or row of cells has.
      const uint32_t x = permutedElement(row, down, hashCombine(hash, 2 * uint64_t(column)));
      const uint32_t y = permutedElement(column, across, hashCombine(hash, 2 * uint64_t(row) + 1));
      const uint64_t within = jitter ? mixBits(hash ^ (cell + uint64_t(1)) * 0xd1b54a32d192ed03ull) : CENTRE;
      numbers[i] = placed(column * down + x, static_cast<uint32_t>(within >> 32));
      numbers[PAIRS + i] = placed(row * across + y, static_cast<uint32_t>(within));
    }
  }

 private:
  static constexpr uint64_t CENTRE = 0x8000000080000000ull;

  /** Number in an interval, by a fraction of 2^-32. */
  float placed(uint32_t interval, uint32_t fraction) const {
    const double x = (interval + fraction * 0x1p-32) / (double(across) * down);
    return std::min(static_cast<float>(x), ONE_MINUS_EPSILON);
  }

  uint32_t across, down;
  bool jitter;
};

} // namespace

void registerStratifiedSampler(PlugIns& plugIns) {
  plugIns.samplers.add(
      {{.name = "stratified",
        .summary = "Each pair of dimensions has one sample in each of xsamples by ysamples cells, and each "
                   "dimension one in each of as many intervals (Chiu, Shirley and Wang 1994). More samples a "
                   "pixel are further sets of this kind. Error estimates are those of independent samples, "
                   "which are too large.",
        .parameters = {integerParameter("xsamples", "4", "samples along x").range(1, 32768),
                       integerParameter("ysamples", "4", "samples along y").range(1, 32768),
                       booleanParameter("jitter", "true",
                                        "random positions within the intervals; false: their centres, which "
                                        "gives a bias"),
                       samplerSeedParameter()},
        .examples = {"", "\"integer xsamples\" 3 \"integer ysamples\" 5"}},
       [](const Parameters& p, const NoContext&) {
         const int across = p.integer("xsamples"), down = p.integer("ysamples");
         auto s = std::make_unique<StratifiedSampler>(uint32_t(across), uint32_t(down), p.boolean("jitter"));
         s->pixelSamples = across * down;
         s->seed = static_cast<uint64_t>(p.integer("seed"));
         return s;
       }});
}

} // namespace recurse
