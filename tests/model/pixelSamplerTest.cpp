/** @file
 * Properties of every registered sampler: uniform numbers, strata as claimed, independent pixels except for
 * blue-noise samplers, no bias, and numbers that depend only on their position.
 */
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <set>

#include "model/shapeTesting.h"
#include "recurse/core/sampling/permutation.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

std::unique_ptr<PixelSampler> makePixelSampler(const std::string& name, const std::string& parameters) {
  Diagnostics diagnostics;
  auto made = plugIns().samplers.make(parseParameterText(name, parameters), NoContext{}, diagnostics);
  EXPECT_TRUE(made) << diagnostics.format();
  return made;
}

/** Calls visit(sampler, description) for each example of each sampler. */
template <class Visitor> void forEachPixelSampler(const Visitor& visit) {
  for (const auto& entry : plugIns().samplers.entries())
    for (const std::string& example : entry.examples)
      visit(*makePixelSampler(entry.name, example), entry.name + " " + example);
}

/** Pairs of dimensions 0, 1, … of a sample. */
std::vector<Vec2f> pairsOf(const PixelSampler& sampler, const PixelSample& sample, size_t count) {
  Sampler s = sampler.sampler(sample);
  std::vector<Vec2f> out(count);
  for (Vec2f& pair : out) pair = s.next2D();
  return out;
}

/** Chi-square statistic of counts with equal expectations, minus its mean, in standard deviations. */
double excess(const std::vector<size_t>& counts) {
  const double expected =
      double(std::accumulate(counts.begin(), counts.end(), size_t(0))) / double(counts.size());
  double sum = 0;
  for (const size_t c : counts) sum += square(double(c) - expected) / expected;
  const double freedom = double(counts.size()) - 1;
  return (sum - freedom) / std::sqrt(2 * freedom);
}

/** Product of a function of each dimension, with integral 1. */
double smoothFunction(const std::vector<Vec2f>& pairs) {
  double product = 1;
  for (const Vec2f& u : pairs) product *= std::exp(double(u.x) + double(u.y)) / square(std::exp(1.0) - 1);
  return product;
}

/** Mean of smoothFunction() of some pairs over the samples of a pixel. */
double estimateIn(const PixelSampler& sampler, uint64_t seed, uint32_t x, uint32_t y, uint32_t samples,
                  size_t pairs) {
  double sum = 0;
  for (uint32_t i = 0; i < samples; ++i)
    sum += smoothFunction(pairsOf(sampler, {seed, x, y, i, samples}, pairs)) / samples;
  return sum;
}

} // namespace

TEST(PixelSamplers, NumbersAreUniformInEachDimensionAndEachPair) {
  // Pair 127 is the last of the Halton sequence.
  constexpr std::array PAIRS = {0, 1, 2, 3, 4, 7, 20, 61, 127, 128, 140};
  constexpr size_t CELLS = 8;
  forEachPixelSampler([&](const PixelSampler& sampler, const std::string& name) {
    std::array<std::array<std::vector<size_t>, 3>, PAIRS.size()> counts;
    for (auto& c : counts) c = {std::vector<size_t>(64), std::vector<size_t>(64), std::vector<size_t>(64)};
    for (uint32_t i = 0; i < 1 << 13; ++i) {
      // One sample of each pixel, because samples of the same pixel are not independent.
      const auto pairs =
          pairsOf(sampler, {1, i % 128, i / 128, uint32_t(mixBits(uint64_t(i)) % 16), 16}, 141);
      for (size_t k = 0; k < PAIRS.size(); ++k) {
        const Vec2f u = pairs[size_t(PAIRS[k])];
        ASSERT_TRUE(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1) << name;
        ++counts[k][0][size_t(u.x * 64)];
        ++counts[k][1][size_t(u.y * 64)];
        ++counts[k][2][size_t(u.x * CELLS) * CELLS + size_t(u.y * CELLS)];
      }
    }
    for (size_t k = 0; k < PAIRS.size(); ++k)
      for (const std::vector<size_t>& c : counts[k]) EXPECT_LT(excess(c), 6) << name << " pair " << PAIRS[k];
  });
}

TEST(PixelSamplers, DimensionsHaveTheStrataThatTheSamplerClaims) {
  constexpr uint32_t PAIRS = 9;
  forEachPixelSampler([&](const PixelSampler& sampler, const std::string& name) {
    for (const uint32_t samples : {1, 4, 8, 15, 16, 27, 49, 64, 200}) {
      std::vector<std::vector<Vec2f>> all;
      for (uint32_t i = 0; i < samples; ++i) all.push_back(pairsOf(sampler, {3, 5, 7, i, samples}, PAIRS));
      for (uint32_t d = 0; d < 2 * PAIRS; ++d) {
        const uint32_t strata = sampler.strata(d, samples);
        ASSERT_EQ(samples % strata, 0u) << name;
        std::vector<size_t> counts(strata);
        for (const auto& pairs : all) ++counts[size_t(double(pairs[d / 2][int(d % 2)]) * strata)];
        EXPECT_EQ(counts, std::vector<size_t>(strata, samples / strata))
            << name << " dimension " << d << ", " << samples << " samples";
      }
    }
  });
  // The claims are not trivial.
  EXPECT_EQ(makePixelSampler("independent", "")->strata(0, 16), 1u);
  for (const char* name : {"stratified", "halton", "sobol", "paddedsobol", "zsobol"})
    EXPECT_EQ(makePixelSampler(name, "")->strata(0, 16), 16u) << name;
  EXPECT_EQ(makePixelSampler("halton", "")->strata(1, 27), 27u);
}

TEST(PixelSamplers, StratifiedPairsHaveOneSampleInEachCell) {
  const auto sampler = makePixelSampler("stratified", "\"integer xsamples\" 3 \"integer ysamples\" 5");
  std::set<std::pair<int, int>> cells;
  for (uint32_t i = 0; i < 15; ++i) {
    const Vec2f u = pairsOf(*sampler, {1, 2, 3, i, 15}, 6)[5];
    cells.insert({int(u.x * 3), int(u.y * 5)});
  }
  EXPECT_EQ(cells.size(), 15u);
}

TEST(PixelSamplers, WithoutJitterStratifiedSamplesAreCentres) {
  const auto sampler = makePixelSampler("stratified", "\"bool jitter\" false");
  std::set<float> numbers;
  for (uint32_t i = 0; i < 16; ++i) numbers.insert(pairsOf(*sampler, {1, 2, 3, i, 16}, 1)[0].x * 16);
  float centre = 0.5f;
  for (const float x : numbers) {
    EXPECT_NEAR(x, centre, 1e-5f);
    ++centre;
  }
  EXPECT_EQ(numbers.size(), 16u);
}

TEST(PixelSamplers, ErrorsOfNeighboursAreIndependentOrTakeEachOtherAway) {
  constexpr uint32_t SIZE = 64;
  constexpr double SIGMA = 1.0 / SIZE; // standard deviation of a correlation
  forEachPixelSampler([&](const PixelSampler& sampler, const std::string& name) {
    for (const uint32_t samples : {1, 16}) {
      std::vector<double> errors;
      double mean = 0, variance = 0;
      for (uint32_t i = 0; i < SIZE * SIZE; ++i) {
        errors.push_back(estimateIn(sampler, 2, i % SIZE, i / SIZE, samples, 1));
        mean += errors.back() / square(SIZE);
      }
      for (double& e : errors) variance += square(e -= mean) / square(SIZE);
      for (const auto& [dx, dy] : {std::pair{1u, 0u}, {0u, 1u}, {1u, 1u}}) {
        double correlation = 0;
        for (uint32_t i = 0; i < SIZE * SIZE; ++i)
          correlation += errors[i] * errors[(i / SIZE + dy) % SIZE * SIZE + (i + dx) % SIZE];
        correlation /= square(SIZE) * variance;
        if (sampler.hasIndependentPixels())
          EXPECT_LT(std::abs(correlation), 5 * SIGMA) << name << ", " << samples << " samples";
        else
          EXPECT_LT(correlation, -2 * SIGMA) << name << ", " << samples << " samples";
      }
    }
  });
  EXPECT_FALSE(makePixelSampler("zsobol", "")->hasIndependentPixels());
}

TEST(PixelSamplers, IntegralsHaveNoBias) {
  constexpr uint32_t ESTIMATES = 4096;
  double independentVariance = 0;
  forEachPixelSampler([&](const PixelSampler& sampler, const std::string& name) {
    double sum = 0, squares = 0;
    for (uint32_t seed = 0; seed < ESTIMATES; ++seed) {
      const double estimate = estimateIn(sampler, seed, 11, 12, 15, 3);
      sum += estimate;
      squares += square(estimate);
    }
    const double mean = sum / ESTIMATES, variance = squares / ESTIMATES - square(mean);
    EXPECT_NEAR(mean, 1, 4.5 * std::sqrt(variance / ESTIMATES)) << name;
    if (name == "independent ") independentVariance = variance;
    // The variance of a product of independent numbers is known; all samplers except `independent` have a
    // smaller one.
    const double second = (std::exp(2.0) - 1) / 2 / square(std::exp(1.0) - 1);
    const double independent = (std::pow(second, 6) - 1) / 15;
    if (name == "independent ")
      EXPECT_NEAR(variance, independent, 0.15 * independent);
    else
      EXPECT_LT(variance, 0.6 * independent) << name;
  });
  EXPECT_GT(independentVariance, 0);
}

TEST(PixelSamplers, NumbersDependOnNothingButTheirPosition) {
  for (const auto& entry : plugIns().samplers.entries()) {
    const auto first = makePixelSampler(entry.name, ""), second = makePixelSampler(entry.name, "");
    std::vector<std::vector<Vec2f>> forwards, backwards;
    for (uint32_t i = 0; i < 64; ++i) forwards.push_back(pairsOf(*first, {1, i % 8, i / 8, i % 5, 4}, 9));
    for (uint32_t i = 64; i-- > 0;) backwards.push_back(pairsOf(*second, {1, i % 8, i / 8, i % 5, 4}, 9));
    std::reverse(backwards.begin(), backwards.end());
    EXPECT_EQ(forwards, backwards) << entry.name;
  }
}

TEST(PixelSamplers, SeedsIndicesAndForksHaveOtherNumbers) {
  forEachPixelSampler([&](const PixelSampler& sampler, const std::string& name) {
    std::set<float> numbers;
    for (uint64_t seed = 0; seed < 4; ++seed)
      for (uint32_t i = 0; i < 64; ++i) { // more samples than the requested 16
        Sampler s = sampler.sampler({seed, 1, 2, i, 16});
        numbers.insert(s.next1D());
        for (uint32_t branch = 0; branch < 2; ++branch) numbers.insert(s.fork(branch).next1D());
      }
    EXPECT_GT(numbers.size(), size_t(4 * 64 * 3 - 4)) << name;
  });
}

TEST(PixelSamplers, SquaresOfPixelsShareStrataByZOrder) {
  const auto sampler = makePixelSampler("zsobol", "");
  for (const uint32_t samples : {1, 2, 4, 8})
    for (const uint32_t size : {2, 4, 8}) {
      const uint32_t total = samples * size * size;
      std::vector<std::set<int>> strata(6);
      for (uint32_t i = 0; i < total; ++i) {
        const uint32_t pixel = i / samples;
        const auto pairs =
            pairsOf(*sampler, {1, 16 + pixel % size, 24 + pixel / size, i % samples, samples}, 3);
        for (size_t d = 0; d < 6; ++d) strata[d].insert(int(pairs[d / 2][int(d % 2)] * float(total)));
      }
      for (const auto& s : strata) EXPECT_EQ(s.size(), total) << samples << " samples, " << size << " pixels";
    }
}

TEST(PixelSamplers, PermutationsHaveEachElementOnceAndAreUniform) {
  for (const uint32_t n : {1, 2, 3, 5, 7, 16, 53}) {
    std::vector<size_t> pairs(size_t(n) * n);
    for (uint64_t seed = 0; seed < 100 * n * n; ++seed) {
      std::set<uint32_t> elements;
      for (uint32_t i = 0; i < n; ++i) elements.insert(permutedElement(i, n, seed));
      ASSERT_EQ(elements.size(), n);
      ASSERT_LT(*elements.rbegin(), n);
      if (n > 1) ++pairs[permutedElement(0, n, seed) * n + permutedElement(n - 1, n, seed)];
    }
    if (n < 2) continue;
    std::vector<size_t> different;
    for (uint32_t i = 0; i < n * n; ++i)
      if (i % n != i / n) different.push_back(pairs[i]);
    EXPECT_LT(excess(different), 6) << n;
  }
}

TEST(PixelSamplers, SayWhatIsWrong) {
  const auto messages = [](const std::string& name, const std::string& parameters) {
    Diagnostics diagnostics;
    plugIns().samplers.make(parseParameterText(name, parameters), NoContext{}, diagnostics);
    return diagnostics.format();
  };
  EXPECT_NE(messages("stratified", "\"integer xsamples\" 32768 \"integer ysamples\" 32769"), "");
  const std::string many = messages("stratified", "\"integer xsamples\" 32768 \"integer ysamples\" 32768");
  EXPECT_EQ(many, ""); // 2^30 samples
  EXPECT_NE(messages("halton", "\"integer pixelsamples\" 0"), "");
  EXPECT_NE(messages("zsobol", "\"integer xsamples\" 4"), "");
}
