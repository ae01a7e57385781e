/** @file
 * Bloom against the integral of the published glare and against direct convolution.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "recurse/core/math/vector.h"
#include "report/develop/bloom.h"

using namespace recurse;

namespace {

Image dots(int width, int height) {
  Image image(width, height, {"R", "G", "B"});
  for (float& v : image.pixels) v = 0.01f;
  image.at(width / 3, height / 2)[0] = 1e4f;
  image.at(2, 0)[1] = 3e3f; // beside the border
  image.at(width - 1, height - 1)[2] = 500;
  return image;
}

double sumOf(const Image& image, size_t channel) {
  double sum = 0;
  for (size_t i = channel; i < image.pixels.size(); i += 3) sum += double(image.pixels[i]);
  return sum;
}

} // namespace

TEST(Bloom, GlareOfAllDirectionsIsTheLight) {
  // Each of the paper's components integrates to 1 over the sphere, so their sum with these weights does.
  double sum = 0, step = 1e-4;
  for (double angle = step / 2; angle < 90; angle += step) {
    if (angle > 1) step = 1e-2;
    sum += glareAt(angle) * 2 * double(PI) * std::sin(angle * double(PI) / 180) * step * double(PI) / 180;
  }
  EXPECT_NEAR(sum, 1, 0.02);
}

TEST(Bloom, KeepsEnergy) {
  for (const auto& [width, height] : {std::pair{64, 48}, {97, 31}, {5, 1}})
    for (double amount : {0.2, 1.0}) {
      const Image before = dots(width, height);
      Image after = before;
      applyBloom(after, amount, 30);
      for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(sumOf(after, c) / sumOf(before, c), 1, 1e-6);
    }
}

TEST(Bloom, UniformPictureStaysAndAmountZeroIsNothing) {
  Image uniform(40, 30, {"R", "G", "B"});
  for (float& v : uniform.pixels) v = 0.7f;
  applyBloom(uniform, 1, 40);
  for (float v : uniform.pixels) ASSERT_NEAR(v, 0.7f, 1e-6f);
  Image same = dots(20, 20);
  applyBloom(same, 0, 40);
  EXPECT_EQ(same.pixels, dots(20, 20).pixels);
}

TEST(Bloom, IsTheConvolutionWithTheGlareOfAMirroredPicture) {
  constexpr int N = 24;
  constexpr double DEGREES = 12; // half a degree per pixel
  Image lamp(N, N, {"R", "G", "B"});
  lamp.at(5, 9)[1] = 1e4f;
  lamp.at(20, 3)[1] = 2e4f;
  const auto glareOfPixel = [](int x,
                               int y) { // mean over a pixel, with more points where the function is steep
    const int parts = x == 0 && y == 0 ? 200 : 20;
    double sum = 0;
    for (int j = 0; j < parts; ++j)
      for (int i = 0; i < parts; ++i)
        sum += glareAt(DEGREES / N * std::hypot(x + (i + 0.5) / parts - 0.5, y + (j + 0.5) / parts - 0.5));
    return sum / (parts * parts);
  };
  const auto mirrored = [](int i) { return i < 0 ? -1 - i : i >= N ? 2 * N - 1 - i : i; };
  double total = 0;
  std::vector<double> direct(N * N);
  for (int dy = -N; dy < N; ++dy)
    for (int dx = -N; dx < N; ++dx) {
      const double weight = glareOfPixel(std::abs(dx), std::abs(dy));
      total += weight;
      for (int y = 0; y < N; ++y)
        for (int x = 0; x < N; ++x)
          direct[size_t(y * N + x)] += weight * double(lamp.at(mirrored(x + dx), mirrored(y + dy))[1]);
    }
  Image bloomed = lamp;
  applyBloom(bloomed, 1, DEGREES);
  for (int y = 0; y < N; ++y)
    for (int x = 0; x < N; ++x) {
      const double expected = direct[size_t(y * N + x)] / total;
      ASSERT_NEAR(double(bloomed.at(x, y)[1]), expected, 0.02 * expected) << x << " " << y;
      ASSERT_EQ(bloomed.at(x, y)[0], 0);
    }
}
