/** @file
 * Noise that pixels of a block share through their photons.
 */
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "transport/weights/mergeWeights.h"

using namespace recurse;

TEST(MergeWeights, SupportsBelowAPixelShareNothing) {
  for (const double radius : {0.0, 0.1, 0.5}) EXPECT_EQ(independence(radius), 1) << radius;
  EXPECT_NEAR(independence(1e6), 1.0 / 64, 1e-4); // all pixels see the same photons
}

/** Counts of photons in discs around the pixels of a block. */
TEST(MergeWeights, IndependenceIsTheGainOfABlockOverThatOfIndependentPixels) {
  constexpr int WIDTH = 8, PIXELS = WIDTH * WIDTH, ROUNDS = 2000;
  std::mt19937 random(1);
  for (const double radius : {1.5, 3.0, 6.0, 12.0}) {
    const double side = WIDTH + 2 * radius, expected = 2 * M_PI * square(radius);
    std::poisson_distribution<int> photons(2 * square(side));
    std::uniform_real_distribution<double> along(-radius, WIDTH + radius);
    double ofPixel = 0, ofBlock = 0;
    for (int round = 0; round < ROUNDS; ++round) {
      std::array<double, PIXELS> counts{};
      for (int left = photons(random); left > 0; --left) {
        const double x = along(random), y = along(random);
        for (int i = 0; i < PIXELS; ++i)
          counts[size_t(i)] += square(i % WIDTH + .5 - x) + square(i / WIDTH + .5 - y) < square(radius);
      }
      double mean = 0;
      for (const double count : counts) {
        mean += count / PIXELS;
        ofPixel += square(count - expected) / PIXELS;
      }
      ofBlock += square(mean - expected);
    }
    const double measured = ofPixel / ofBlock / PIXELS;
    EXPECT_NEAR(independence(radius) / measured, 1, .15) << radius; // three standard errors, and 6 %
  }
}
