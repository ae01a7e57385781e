/** @file
 * Error measures against values computed by hand, and noise-free measures with known noise.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include <nlohmann/json.hpp>

#include "recurse/core/io/error.h"
#include "recurse/report/compare/compare.h"
#include "report/compare/falseColour.h"
#include "report/noise.h"

using namespace recurse;

namespace {

Image constant(int width, int height, const Rgb& colour) {
  Image image(width, height, {"R", "G", "B"});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = colour[c];
  return image;
}

} // namespace

TEST(Compare, ClosedForm) {
  // Two pixels: x = (1, 2, 4), (3, 2, 1); r = (2, 2, 2), (1, 2, 4).
  Image x = constant(2, 1, {1, 2, 4}), r = constant(2, 1, {2, 2, 2});
  x.pixels = {1, 2, 4, 3, 2, 1};
  r.pixels = {2, 2, 2, 1, 2, 4};
  const Comparison c = compareImages(x, r);
  EXPECT_EQ(c.pixels, 2u);
  EXPECT_DOUBLE_EQ(c.mean[0], 2);
  EXPECT_DOUBLE_EQ(c.meanReference[2], 3);
  EXPECT_DOUBLE_EQ(c.mean[ALL_CHANNELS], 13 / 6.0);
  EXPECT_DOUBLE_EQ(c.meanRatio[0], 2 / 1.5);
  EXPECT_DOUBLE_EQ(c.meanRatio[ALL_CHANNELS], 1);
  EXPECT_DOUBLE_EQ(c.mse[0], 2.5);
  EXPECT_DOUBLE_EQ(c.mse[1], 0);
  EXPECT_DOUBLE_EQ(c.mse[ALL_CHANNELS], (1 + 0 + 4 + 4 + 0 + 9) / 6.0);
  EXPECT_DOUBLE_EQ(c.relMse[0], (1 / 4.01 + 4 / 1.01) / 2);
  EXPECT_DOUBLE_EQ(c.relMse[2], (4 / 4.01 + 9 / 16.01) / 2);
  EXPECT_DOUBLE_EQ(c.relMse[ALL_CHANNELS], (1 / 4.01 + 4 / 4.01 + 4 / 1.01 + 9 / 16.01) / 6);
  EXPECT_DOUBLE_EQ(c.mape[0], (1 / 2.01 + 2 / 1.01) / 2);
  EXPECT_DOUBLE_EQ(c.smape[0], (1 / 1.51 + 2 / 2.01) / 2);
  EXPECT_DOUBLE_EQ(c.maximum[0], 2);
  EXPECT_DOUBLE_EQ(c.maximum[ALL_CHANNELS], 3);
  EXPECT_DOUBLE_EQ(c.psnr[0], 10 * std::log10(4 / 2.5));
  EXPECT_DOUBLE_EQ(c.psnr[ALL_CHANNELS], 10 * std::log10(16 / 3.0));
  EXPECT_TRUE(std::isinf(c.psnr[1]));
  ASSERT_EQ(c.worst.size(), 2u);
  EXPECT_EQ(c.worst[0].x, 1);
  EXPECT_DOUBLE_EQ(c.worst[0].error, (4 / 1.01 + 9 / 16.01) / 3);
  EXPECT_FALSE(c.noiseFree);
}

TEST(Compare, TrimmingTakesTheWorstThousandth) {
  const Image r = constant(100, 50, Rgb(1));
  Image x = constant(100, 50, Rgb(1.1f));
  for (int i = 0; i < 5; ++i) x.at(7 * i, 3 + i)[1] = 1000.0f * float(i + 1);
  const Comparison c = compareImages(x, r);
  EXPECT_EQ(c.trimmedPixels, 5u);
  EXPECT_GT(c.relMse[ALL_CHANNELS], 1000);
  EXPECT_NEAR(c.relMseTrimmed[ALL_CHANNELS], 0.01 / 1.01, 1e-8);
  ASSERT_EQ(c.worst.size(), 5u);
  EXPECT_EQ(c.worst[0].x, 28);
  EXPECT_EQ(c.worst[0].y, 7);
}

TEST(Compare, NoiseFreeErrorForgetsTheReferencesNoise) {
  // The picture has a bias of 0.05 and noise of 0.1: its squared error is 0.0125. The references have more
  // noise, which the plain error includes.
  const Image truth = constant(300, 300, Rgb(0.5f, 1, 2));
  const Image x = noisy(constant(300, 300, Rgb(0.55f, 1.05f, 2.05f)), 0.1, 1);
  const Image a = noisy(truth, 0.2, 2), b = noisy(truth, 0.2, 3);
  const Comparison c = compareImages(x, a, b, &truth);
  ASSERT_TRUE(c.noiseFree);
  EXPECT_NEAR(c.mseNoiseFree[ALL_CHANNELS], 0.0125, 0.0005);
  for (size_t i = 0; i < 3; ++i) {
    const double r = 0.5 * double(1 << i);
    EXPECT_NEAR(c.relMseNoiseFree[i], 0.0125 / (r * r + 0.01), 0.001 / (r * r));
  }
  const Comparison plain = compareImages(x, a);
  EXPECT_NEAR(plain.mse[ALL_CHANNELS], 0.0125 + 0.04, 0.001);
  // Without a third picture r is the mean of the two, whose noise remains in the denominator; the products do
  // not depend on it.
  const Comparison mean = compareImages(x, a, b);
  EXPECT_DOUBLE_EQ(mean.mseNoiseFree[0], c.mseNoiseFree[0]);
  EXPECT_NEAR(mean.relMseNoiseFree[2], c.relMseNoiseFree[2], 1e-3);
  EXPECT_NEAR(mean.mse[ALL_CHANNELS], 0.0125 + 0.02, 0.001);
}

TEST(Compare, NoiseFreeErrorOfThePerfectPictureIsZeroInTheMean) {
  const Image truth = constant(400, 400, Rgb(1));
  const Comparison c = compareImages(truth, noisy(truth, 0.3, 4), noisy(truth, 0.3, 5), &truth);
  // The standard error of a mean of 480000 products of deviation 0.09.
  EXPECT_LT(std::abs(c.mseNoiseFree[ALL_CHANNELS]), 5 * 0.09 / std::sqrt(480000.0));
}

TEST(Compare, NonFinitePixelsAreCountedAndLeftOut) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinite = std::numeric_limits<float>::infinity();
  Image x = constant(4, 1, Rgb(2)), r = constant(4, 1, Rgb(1));
  r.at(0, 0)[1] = infinite;
  x.at(1, 0)[2] = nan;
  Comparison c = compareImages(x, r);
  EXPECT_EQ(c.nonFiniteReference, 1u);
  EXPECT_EQ(c.nonFinite, 1u);
  EXPECT_EQ(c.pixels, 2u);
  EXPECT_DOUBLE_EQ(c.mse[ALL_CHANNELS], 1);
  EXPECT_NE(comparisonTable(c).find("1 pixels left out"), std::string::npos);
  EXPECT_NE(comparisonTable(c).find("1 pixels of the picture are NOT FINITE"), std::string::npos);
  Image b = constant(4, 1, Rgb(1));
  b.at(3, 0)[0] = -infinite;
  c = compareImages(x, r, b);
  EXPECT_EQ(c.nonFiniteReference, 2u);
  EXPECT_EQ(c.pixels, 1u);
}

TEST(Compare, NothingToCompareIsNotZeroError) {
  const Image r = constant(2, 2, Rgb(std::numeric_limits<float>::quiet_NaN()));
  const Comparison c = compareImages(constant(2, 2, Rgb(1)), r);
  EXPECT_EQ(c.pixels, 0u);
  EXPECT_TRUE(std::isnan(c.mse[ALL_CHANNELS]));
  EXPECT_TRUE(nlohmann::json::parse(comparisonJson(c))["mse"].is_null());
}

TEST(Compare, SizesMustAgree) {
  try {
    compareImages(constant(2, 3, Rgb(1)), constant(3, 2, Rgb(1)));
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "the pictures differ in size: 2x3, and the reference has 3x2");
  }
  const Image a = constant(2, 2, Rgb(1));
  EXPECT_THROW(compareImages(a, a, constant(2, 1, Rgb(1))), Error);
  Image grey(2, 2, {"Y"});
  EXPECT_THROW(compareImages(grey, a), Error);
}

TEST(Compare, JsonHasEveryKey) {
  const Image a = constant(2, 2, Rgb(1)), b = constant(2, 2, Rgb(2));
  const nlohmann::json json = nlohmann::json::parse(comparisonJson(compareImages(a, b, b)));
  for (const char* key : {"mse", "relmse", "relmse_trimmed", "mape", "smape", "max", "psnr", "mean_ratio",
                          "mean_ratio_rgb", "non_finite", "mse_noise_free", "relmse_noise_free"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_DOUBLE_EQ(json["mean_ratio"], 0.5);
  EXPECT_EQ(json["mean_ratio_rgb"].size(), 3u);
  EXPECT_FALSE(nlohmann::json::parse(comparisonJson(compareImages(a, b))).contains("mse_noise_free"));
}

TEST(Compare, MetricsByName) {
  const Image a = constant(2, 2, Rgb(1)), b = constant(2, 2, Rgb(2));
  const Comparison c = compareImages(a, b);
  EXPECT_DOUBLE_EQ(metricByName(c, "mse"), 1);
  EXPECT_DOUBLE_EQ(metricByName(c, "non_finite"), 0);
  EXPECT_THROW(metricByName(c, "relmse_noise_free"), Error);
  EXPECT_THROW(metricByName(c, "mean_squared"), Error);
  for (const std::string& name : metricNames())
    if (name.find("noise_free") == std::string::npos && name.find("flip") == std::string::npos) {
      EXPECT_NO_THROW(metricByName(c, name)) << name;
    }
}

TEST(Compare, EveryRelativeErrorSaysHowItIsMade) {
  const Image a = constant(2, 2, Rgb(1)), b = constant(2, 2, Rgb(2));
  std::istringstream table(comparisonTable(compareImages(a, b, b)));
  int lines = 0;
  for (std::string line; std::getline(table, line);) {
    if (line.find("relMSE") != 0) continue;
    ++lines;
    EXPECT_NE(line.find("ε 0.01"), std::string::npos) << line;
    EXPECT_NE(line.find("²+ε"), std::string::npos) << line;
    EXPECT_TRUE(line.find("trim") != std::string::npos) << line;
  }
  EXPECT_EQ(lines, 5);
}

TEST(Compare, ErrorMaps) {
  float last = -1;
  for (int i = 0; i <= 100; ++i) { // increasing luminance, inside the gamut
    const Rgb c = falseColour(float(i) / 100);
    EXPECT_GT(luminance(c), last) << i;
    last = luminance(c);
    for (int k = 0; k < 3; ++k) {
      EXPECT_GE(c[k], 0);
      EXPECT_LE(c[k], 1);
    }
  }
  const Image r = constant(3, 1, Rgb(1));
  Image x = r;
  for (int c = 0; c < 3; ++c) x.at(1, 0)[c] = 2.5f, x.at(2, 0)[c] = 0.25f;
  const Image relative = errorMap(x, r, ErrorMap::RELATIVE);
  EXPECT_EQ(relative.rgb(0, 0), falseColour(0));
  EXPECT_EQ(relative.rgb(1, 0), falseColour(1));
  const Image sign = errorMap(x, r, ErrorMap::SIGNED);
  EXPECT_GT(sign.rgb(1, 0).r, sign.rgb(1, 0).b); // too bright: red
  EXPECT_LT(sign.rgb(2, 0).r, sign.rgb(2, 0).b); // too dark: blue
  x.at(0, 0)[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(errorMap(x, r, ErrorMap::RELATIVE).rgb(0, 0), Rgb(1, 0, 1));
}

TEST(ErrorByScale, IndependentNoiseFallsToAQuarterAndAStainStays) {
  const Image truth = constant(128, 96, {0.5f, 0.5f, 0.5f});
  const Image a = noisy(truth, 0.05, 1), b = noisy(truth, 0.05, 2);
  const ByScale noise = compareImages(noisy(truth, 0.1, 3), a, b).relMseNoiseFreeByScale;
  for (size_t i = 1; i < 4; ++i) EXPECT_NEAR(noise[i - 1] / noise[i], 4, 0.8) << i;
  EXPECT_NEAR(noise[0], 0.01 / 0.26, 0.1 * 0.01 / 0.26);
  Image stained = truth; // squares of 32 pixels, alternately a tenth too bright and too dark
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0; x < truth.width; ++x)
      for (int c = 0; c < 3; ++c) stained.at(x, y)[c] *= (x / 32 + y / 32) % 2 ? 1.1f : 0.9f;
  for (double error : compareImages(stained, truth).relMseByScale) EXPECT_NEAR(error, 0.0025 / 0.26, 1e-6);
  EXPECT_TRUE(
      std::isnan(compareImages(constant(20, 9, {1, 1, 1}), constant(20, 9, {1, 1, 1})).relMseByScale[4]));
}

TEST(ErrorByScale, NoiseOfTheReferenceDoesNotWeighDarkPixelsUp) {
  const Image truth = constant(64, 64, {0.2f, 0.2f, 0.2f});
  const Image a = noisy(truth, 0.15, 1), b = noisy(truth, 0.15, 2);
  const double known = 0.01 / (0.04 + REL_MSE_EPSILON);
  const Comparison c = compareImages(constant(64, 64, {0.3f, 0.3f, 0.3f}), a, b);
  EXPECT_NEAR(c.relMseNoiseFreeByScale[0], known, 0.08 * known);
  EXPECT_NEAR(c.relMseNoiseFreeByScale[3], known, 0.08 * known);
  EXPECT_GT(c.relMseNoiseFree[ALL_CHANNELS], 1.1 * known); // value without smoothing
  EXPECT_EQ(metricByName(c, "relmse_noise_free_at_8"), c.relMseNoiseFreeByScale[3]);
  EXPECT_NE(comparisonTable(c).find("8x8"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(comparisonJson(c))["relmse_noise_free_at_8"], c.relMseNoiseFreeByScale[3]);
}

namespace {

/** Stills of two classes of paths, and their sum. */
Image twoClasses(const Image& direct, const Image& caustic, const std::string& causticExpression = "LS+DE") {
  Image stills(direct.width, direct.height,
               {"R", "G", "B", "direct.R", "direct.G", "direct.B", "caustic.R", "caustic.G", "caustic.B"});
  for (int y = 0; y < stills.height; ++y)
    for (int x = 0; x < stills.width; ++x)
      for (int c = 0; c < 3; ++c) {
        stills.at(x, y)[3 + c] = direct.at(x, y)[c];
        stills.at(x, y)[6 + c] = caustic.at(x, y)[c];
        stills.at(x, y)[c] = direct.at(x, y)[c] + caustic.at(x, y)[c];
      }
  stills.metadata["recurse:classes"] = "direct = LDE; caustic = " + causticExpression;
  return stills;
}

} // namespace

TEST(ClassErrors, EachIsThatOfItsOwnLayer) {
  const Image direct = constant(128, 96, {0.3f, 0.3f, 0.3f}), caustic = constant(128, 96, {0.2f, 0.2f, 0.2f});
  const auto reference = [&](unsigned seed) {
    return twoClasses(noisy(direct, 0.05, seed), noisy(caustic, 0.05, seed + 1));
  };
  const Image a = reference(1), b = reference(3);
  const Image x = twoClasses(noisy(direct, 0.1, 5), constant(128, 96, {0.22f, 0.22f, 0.22f}));
  Comparison c = compareImages(x, a, b);
  addClasses(c, x, a, &b);
  ASSERT_EQ(c.classes.size(), 3u);
  EXPECT_EQ(c.classes[0].name, "beauty");
  EXPECT_EQ(c.classes[0].relMseNoiseFreeByScale[0], c.relMseNoiseFreeByScale[0]);
  EXPECT_EQ(c.classes[1].expression, "LDE");
  EXPECT_NEAR(c.classes[1].share, 0.6, 0.01);
  const ByScale& noise = c.classes[1].relMseNoiseFreeByScale;
  EXPECT_NEAR(noise[0], 0.1, 0.01); // 0.1² / (0.3² + 0.01)
  for (size_t i = 1; i < 4; ++i) EXPECT_NEAR(noise[i - 1] / noise[i], 4, 0.8) << i;
  for (size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(c.classes[2].relMseNoiseFreeByScale[i], 0.008, 0.001) << i; // 0.02² / (0.2² + 0.01)
  const std::string table = comparisonTable(c);
  for (const char* part : {"relMSE of classes, noise-free", "LS+DE", "60 %"})
    EXPECT_NE(table.find(part), std::string::npos) << part << "\n" << table;
  const nlohmann::json json = nlohmann::json::parse(comparisonJson(c))["classes"];
  ASSERT_EQ(json.size(), 3u);
  EXPECT_EQ(json[2]["name"], "caustic");
  EXPECT_EQ(json[1]["relmse_noise_free_at_8"], noise[3]);
  EXPECT_EQ(json[1]["relmse_at_2"], c.classes[1].relMseByScale[1]);
}

TEST(ClassErrors, ClassesOfOtherPathsAreLeftOutAndPicturesWithoutClassesHaveNone) {
  const Image grey = constant(16, 16, {0.3f, 0.3f, 0.3f});
  const Image x = twoClasses(grey, grey), other = twoClasses(grey, grey, "LS+D+E");
  Comparison c = compareImages(x, other);
  addClasses(c, x, other);
  EXPECT_EQ(c.classes.size(), 2u);
  ASSERT_EQ(c.classesLeftOut.size(), 1u);
  EXPECT_NE(comparisonTable(c).find("caustic: it is LS+DE, in a reference LS+D+E"), std::string::npos);
  Comparison plain = compareImages(grey, x);
  addClasses(plain, grey, x);
  EXPECT_TRUE(plain.classes.empty());
  EXPECT_EQ(comparisonTable(plain).find("classes"), std::string::npos);
}
