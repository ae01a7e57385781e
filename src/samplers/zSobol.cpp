/** @file
 * Sobol' points along a Z-order of the pixels, so that the error is blue noise: A. G. M. Ahmed and P. Wonka,
 * "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", ACM
 * Transactions on Graphics 39(6), 2020.
 */
#include <algorithm>
#include <bit>

#include "recurse/model/camera/pixelSampler.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** All permutations of four digits, each with two bits for each digit. */
constexpr std::array<uint8_t, 24> digitPermutations() {
  std::array<uint8_t, 24> out{};
  std::array<uint8_t, 4> digits{0, 1, 2, 3};
  for (uint8_t& permutation : out) {
    for (size_t i = 0; i < 4; ++i) permutation = uint8_t(permutation | digits[i] << (2 * i));
    std::next_permutation(digits.begin(), digits.end());
  }
  return out;
}

constexpr std::array<uint8_t, 24> DIGIT_PERMUTATIONS = digitPermutations();

/** Moves bit i to bit 2 i. */
constexpr uint64_t spreadBits(uint64_t v) {
  v = (v | v << 16) & 0x0000ffff0000ffffull;
  v = (v | v << 8) & 0x00ff00ff00ff00ffull;
  v = (v | v << 4) & 0x0f0f0f0f0f0f0f0full;
  v = (v | v << 2) & 0x3333333333333333ull;
  return (v | v << 1) & 0x5555555555555555ull;
}

/** Permutes each base-4 digit of a pixel's Z-order by a hash of the digits above it. */
uint32_t permutedDigits(uint32_t pixel, uint32_t digits, uint64_t hash) {
  uint32_t out = 0;
  for (uint32_t shift = 2 * digits; shift > 0;) {
    shift -= 2;
    // The leading 1 distinguishes numbers of different lengths.
    const uint64_t above = (pixel | 1ull << (2 * digits)) >> shift >> 2;
    const uint64_t node = mixBits(hash ^ above);
    const uint32_t permutation = DIGIT_PERMUTATIONS[(node >> 32) * DIGIT_PERMUTATIONS.size() >> 32];
    out |= (permutation >> (2 * (pixel >> shift & 3)) & 3) << shift;
  }
  return out;
}

/**
 * A square block of pixels shares one Sobol' sequence for each pair of dimensions. A pixel has 2^k
 * consecutive points, in the Z-order of the pixels: the union of any aligned square of pixels is an
 * elementary interval of the sequence. Blocks have 2^24 points, 2^23 for odd k: floats distinguish
 * them. Blocks are independent, and so are further 2^k samples of a pixel.
 */
class ZSobolSampler final : public PixelSampler, public SamplePoints {
 public:
  ZSobolSampler() : PixelSampler(true) {}
  Sampler samplerOfPoints(const PixelSample& s) const override {
    const uint32_t bits =
        std::min<uint32_t>(INDEX_BITS, static_cast<uint32_t>(std::bit_width(s.requested - 1)));
    const uint32_t digits = (INDEX_BITS - bits) / 2;
    const uint64_t pixel = spreadBits(s.x) | spreadBits(s.y) << 1;
    const uint64_t inBlock = pixel & ((1ull << (2 * digits)) - 1);
    const uint64_t key = hashCombine(hashCombine(mixBits(s.seed), pixel >> (2 * digits)), s.index >> bits);
    const uint64_t index = inBlock << bits | (s.index & ((1u << bits) - 1));
    return {*this, key, static_cast<uint32_t>(index) | bits << INDEX_BITS};
  }
  uint32_t strata(uint32_t, uint32_t samples) const override {
    return std::min(largestPowerDividing(samples, 2), 1u << INDEX_BITS);
  }
  bool hasIndependentPixels() const override { return false; }

  void fill(uint64_t key, uint32_t index, uint32_t first, float* numbers) const override {
    const uint32_t bits = index >> INDEX_BITS, ofPixel = (1u << bits) - 1;
    const uint32_t pixel = (index & ((1u << INDEX_BITS) - 1)) >> bits;
    const uint32_t reversedSample = reverseBits(index & ofPixel);
    Pairs indices, seeds;
    for (uint32_t i = 0; i < PAIRS; ++i) {
      const uint64_t hash = pairHash(key, first + i);
      const uint32_t permuted = permutedDigits(pixel, (INDEX_BITS - bits) / 2, hash);
      // The samples of a pixel are shuffled as by Owen scrambling, so that 2^j of them are stratified too.
      const auto shuffle = static_cast<uint32_t>(mixBits(hash + pixel));
      indices[i] =
          reverseBits(permuted << bits) | (scrambleReversed(reversedSample, shuffle) & reverseBits(ofPixel));
      seeds[i] = static_cast<uint32_t>(hash >> 32);
    }
    fillSobol(indices, seeds, numbers);
  }

 private:
  static constexpr uint32_t INDEX_BITS = 24;
};

} // namespace

void registerZSobolSampler(PlugIns& plugIns) {
  plugIns.samplers.add(
      {{.name = "zsobol",
        .summary = "Owen-scrambled Sobol' points along a Z-order of the pixels, so that the errors of "
                   "neighbours differ: blue noise (Ahmed and Wonka 2020).",
        .parameters = pixelSamplerParameters(
            {ignoredParameter(ParameterType::STRING, "randomization", "always Owen scrambling")}),
        .examples = {""}},
       [](const Parameters& p, const NoContext&) {
         return withPixelSamples(std::make_unique<ZSobolSampler>(), p);
       }});
}

} // namespace recurse
