/** @file
 * Halton sequence with Owen scrambling of its digits, independent for each pixel.
 */
#include "recurse/model/camera/pixelSampler.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Number of dimensions of the sequence; those of a path beyond it are independent random numbers. */
constexpr size_t HALTON_DIMENSIONS = 256;

constexpr std::array<uint32_t, HALTON_DIMENSIONS> firstPrimes() {
  std::array<uint32_t, HALTON_DIMENSIONS> primes{};
  size_t count = 0;
  for (uint32_t n = 2; count < primes.size(); ++n) {
    bool isPrime = true;
    for (size_t i = 0; i < count && primes[i] * primes[i] <= n; ++i) isPrime = isPrime && n % primes[i] != 0;
    if (isPrime) primes[count++] = n;
  }
  return primes;
}

constexpr std::array<uint32_t, HALTON_DIMENSIONS> PRIMES = firstPrimes();

/**
 * Radical inverse of `index` in a prime base, scrambled as by Owen 1995: each digit is permuted by a hash of
 * the digits before it. Permutations are affine, modulo the base (Matousek, "On the L2-discrepancy for
 * anchored boxes", 1998): pairs of digits are as uniform as with all permutations, and so is the variance.
 */
float scrambledRadicalInverse(uint32_t index, uint32_t base, uint64_t seed) {
  double number = 0, cell = 1;
  uint64_t node = mixBits(seed);
  while (cell > 0x1p-24) { // the resolution of unitFloat()
    const uint32_t digit = index % base;
    index /= base;
    cell /= base;
    const uint64_t factor = 1 + ((node >> 32) * (base - 1) >> 32), shift = (node & 0xffffffffu) * base >> 32;
    number += cell * static_cast<double>((digit * factor + shift) % base);
    node = hashCombine(node, digit);
  }
  number += cell * 0x1p-32 * static_cast<double>(node >> 32);
  return std::min(static_cast<float>(number), ONE_MINUS_EPSILON);
}

class HaltonSampler final : public PixelSampler, public SamplePoints {
 public:
  HaltonSampler() : PixelSampler(true) {}
  Sampler samplerOfPoints(const PixelSample& s) const override {
    return {*this, hashCombine(mixBits(s.seed), s.pixel()), s.index};
  }
  uint32_t strata(uint32_t dimension, uint32_t samples) const override {
    return dimension < HALTON_DIMENSIONS ? largestPowerDividing(samples, PRIMES[dimension]) : 1;
  }

  void fill(uint64_t key, uint32_t index, uint32_t first, float* numbers) const override {
    for (uint32_t i = 0; i < PAIRS; ++i) {
      const uint64_t hash = pairHash(key, first + i);
      for (uint32_t axis = 0; axis < 2; ++axis) {
        const size_t dimension = 2 * (size_t(first) + i) + axis;
        const uint64_t seed = hashCombine(hash, axis);
        numbers[axis * PAIRS + i] = dimension < HALTON_DIMENSIONS
                                        ? scrambledRadicalInverse(index, PRIMES[dimension], seed)
                                        : unitFloat(static_cast<uint32_t>(hashCombine(seed, index) >> 32));
      }
    }
  }
};

} // namespace

void registerHaltonSampler(PlugIns& plugIns) {
  plugIns.samplers.add(
      {{.name = "halton",
        .summary = "Halton points (1960) of a prime number for each dimension, with Owen-scrambled digits; "
                   "each pixel has a sequence of its own.",
        .parameters = pixelSamplerParameters(
            {ignoredParameter(ParameterType::STRING, "randomization", "always Owen scrambling")}),
        .examples = {""}},
       [](const Parameters& p, const NoContext&) {
         return withPixelSamples(std::make_unique<HaltonSampler>(), p);
       }});
}

} // namespace recurse
