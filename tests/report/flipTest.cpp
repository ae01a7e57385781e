/** @file
 * FLIP against values of an independent implementation in double precision, with two-dimensional filters as
 * in the papers, and against closed forms for simple pictures.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "recurse/core/io/error.h"
#include "recurse/report/compare/compare.h"
#include "recurse/report/compare/flip.h"
#include "report/compare/falseColour.h"

using namespace recurse;

namespace {

Image constant(const Rgb& colour, int width = 24, int height = 16) {
  Image image(width, height, {"R", "G", "B"});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = colour[c];
  return image;
}

/** Waves, a checkerboard and a disk far brighter than white; `changed` adds waves and a green spot. */
Image picture(bool changed) {
  Image image(48, 36, {"R", "G", "B"});
  for (int i = 0; i < 36; ++i)
    for (int j = 0; j < 48; ++j)
      for (int c = 0; c < 3; ++c) {
        double v = 0.4 + 0.3 * std::sin(0.31 * j + 0.17 * c * i) + 0.25 * std::cos(0.23 * i - 0.4 * c);
        if ((j - 20) * (j - 20) + (i - 15) * (i - 15) < 60) v *= 9 + 30 * c;
        if ((j / 6 + i / 6) % 2 != 0) v *= 0.1;
        if (changed) {
          v *= 1 + 0.3 * std::sin(1.7 * j + 2.3 * i + c);
          if (c == 1 && (j - 35) * (j - 35) + (i - 25) * (i - 25) < 16) v += 0.3;
        }
        image.at(j, i)[c] = static_cast<float>(v);
      }
  return image;
}

double at(const Flip& flip, int x, int y) {
  return double(flip.errors[size_t(y) * size_t(flip.width) + size_t(x)]);
}

} // namespace

TEST(Flip, LdrAgreesWithASeparateImplementation) {
  const Flip flip = ldrFlip(picture(true), picture(false));
  EXPECT_NEAR(flip.mean, 0.0893529, 2e-5);
  EXPECT_NEAR(at(flip, 10, 10), 0.0088535, 2e-5);
  EXPECT_NEAR(at(flip, 35, 25), 0.8554003, 2e-5);
  EXPECT_NEAR(at(flip, 0, 0), 0.1913955, 2e-5);
}

TEST(Flip, HdrAgreesWithASeparateImplementation) {
  const Flip flip = hdrFlip(picture(true), picture(false));
  EXPECT_NEAR(flip.mean, 0.0946078, 2e-5);
  EXPECT_NEAR(at(flip, 10, 10), 0.0502724, 2e-5);
  EXPECT_NEAR(at(flip, 35, 25), 0.8740203, 2e-5);
  EXPECT_NEAR(at(flip, 0, 0), 0.1603261, 2e-5);
  ASSERT_EQ(flip.exposures.size(), 8u);
  EXPECT_NEAR(flip.exposures.front(), -3.5084446, 1e-5);
  EXPECT_NEAR(flip.exposures.back(), 3.6025889, 1e-5);
}

TEST(Flip, RangeFromNothingToGreenAgainstBlue) {
  EXPECT_EQ(ldrFlip(picture(true), picture(true)).mean, 0);
  EXPECT_EQ(hdrFlip(picture(true), picture(true)).mean, 0);
  // The pair of colours that defines the largest error; without features the error is the colour error.
  EXPECT_NEAR(ldrFlip(constant({0, 1, 0}), constant({0, 0, 1})).mean, 1, 1e-5);
  const Flip there = ldrFlip(picture(true), picture(false)), back = ldrFlip(picture(false), picture(true));
  EXPECT_DOUBLE_EQ(there.mean, back.mean);
  for (float error : there.errors) {
    EXPECT_GE(error, 0);
    EXPECT_LE(error, 1);
  }
}

TEST(Flip, ADisplayShowsNothingAboveWhite) {
  EXPECT_EQ(ldrFlip(constant(Rgb(3)), constant(Rgb(7))).mean, 0);
  EXPECT_GT(hdrFlip(constant(Rgb(3)), constant(Rgb(7))).mean, 0.1);
  // HDR-FLIP chooses its exposures from the reference, so the scale of both does not matter.
  const auto scaled = [](float scale, float exposure) {
    Image image = picture(exposure > 0);
    for (float& value : image.pixels) value *= scale;
    return image;
  };
  EXPECT_NEAR(hdrFlip(scaled(1000, 1), scaled(1000, 0)).mean, 0.0946078, 2e-5);
}

TEST(Flip, DarkPictures) {
  // A black picture has no exposure; a mostly black one has no finite exposure for its median, and uses the
  // lit pixels.
  EXPECT_EQ(hdrFlip(constant(Rgb(0)), constant(Rgb(0))).mean, 0);
  Image lamp = constant(Rgb(0));
  for (int c = 0; c < 3; ++c) lamp.at(3, 3)[c] = 5;
  const Flip flip = hdrFlip(constant(Rgb(0)), lamp);
  EXPECT_TRUE(std::isfinite(flip.mean));
  EXPECT_GT(flip.mean, 0);
  for (double exposure : flip.exposures) EXPECT_TRUE(std::isfinite(exposure));
}

TEST(Flip, NotFiniteAndOfOtherSize) {
  Image broken = picture(true);
  broken.at(3, 4)[1] = std::numeric_limits<float>::infinity();
  for (const Flip& flip : {ldrFlip(broken, picture(false)), hdrFlip(picture(false), broken)}) {
    EXPECT_TRUE(std::isnan(flip.mean));
    EXPECT_THROW(flipMap(flip), Error);
  }
  EXPECT_THROW(ldrFlip(picture(true), constant(Rgb(1))), Error);
  EXPECT_THROW(hdrFlip(constant(Rgb(1)), picture(true)), Error);
}

TEST(Flip, InTheComparison) {
  Comparison c = compareImages(picture(true), picture(false));
  EXPECT_THROW(metricByName(c, "flip"), Error);
  EXPECT_FALSE(nlohmann::json::parse(comparisonJson(c)).contains("hdrflip"));
  addFlip(c, picture(true), picture(false));
  const nlohmann::json json = nlohmann::json::parse(comparisonJson(c));
  EXPECT_NEAR(json["flip"], 0.0893529, 2e-5);
  EXPECT_NEAR(json["hdrflip"], 0.0946078, 2e-5);
  EXPECT_EQ(json["flip"], metricByName(c, "flip"));
  EXPECT_NE(comparisonTable(c).find("HDR-FLIP"), std::string::npos);
  const Image map = flipMap(*c.flip);
  EXPECT_EQ(map.rgb(35, 25), falseColour(c.flip->errors[25 * 48 + 35]));
}
