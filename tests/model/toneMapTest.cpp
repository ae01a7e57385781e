/** @file
 * Properties of every registered tone operator, and the published curve of each.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "recurse/model/film/toneCurve.h"
#include "recurse/model/scene/plugIns.h"

using namespace recurse;

namespace {

Image pictureOf(int width, int height, const std::function<Rgb(float, float)>& colour) {
  Image picture(width, height, {"R", "G", "B"});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Rgb c = colour((float(x) + 0.5f) / float(width), (float(y) + 0.5f) / float(height));
      for (int i = 0; i < 3; ++i) picture.at(x, y)[i] = c[i];
    }
  return picture;
}

Image uniform(const Rgb& colour) {
  return pictureOf(24, 16, [&](float, float) { return colour; });
}

std::unique_ptr<ToneMap> makeToneMap(const std::string& name, const std::string& parameters = "") {
  Diagnostics diagnostics;
  auto made = plugIns().toneMaps.make(parseParameterText(name, parameters), NoContext{}, diagnostics);
  EXPECT_TRUE(made) << name << " " << parameters << "\n" << diagnostics.format();
  return made;
}

Image mapped(const ToneMap& toneMap, Image picture) {
  toneMap.apply(picture);
  return picture;
}

/** Calls check(operator, name) for every example of every registered operator. */
void forEachToneMap(const std::function<void(const ToneMap&)>& check) {
  ASSERT_GE(plugIns().toneMaps.entries().size(), 7u);
  for (const auto& entry : plugIns().toneMaps.entries())
    for (const std::string& example : entry.examples) {
      SCOPED_TRACE(entry.name + " " + example);
      check(*makeToneMap(entry.name, example));
    }
}

/** Grey from dark to bright, 1e-4 to 1e3, from left to right. */
Image ramp() {
  return pictureOf(256, 4, [](float x, float) { return Rgb(std::pow(10.0f, -4 + 7 * x)); });
}

} // namespace

TEST(ToneMaps, BlackStaysBlack) {
  forEachToneMap([](const ToneMap& toneMap) {
    EXPECT_EQ(mapped(toneMap, uniform(BLACK)).pixels, uniform(BLACK).pixels);
    const Image half =
        mapped(toneMap, pictureOf(32, 8, [](float x, float) { return x < 0.5f ? BLACK : Rgb(5, 1, 0); }));
    for (int x = 0; x < 16; ++x) EXPECT_EQ(half.rgb(x, 3), BLACK) << x;
  });
}

TEST(ToneMaps, GreyCardIsKept) {
  forEachToneMap([](const ToneMap& toneMap) {
    const Rgb grey = mapped(toneMap, uniform(Rgb(GREY_CARD))).rgb(5, 5);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(grey[c], GREY_CARD, 1e-4f);
    // The grey card keeps its value beside much darker and brighter pixels as well.
    const Image in = ramp();
    const Image out = mapped(toneMap, in);
    for (int x = 0; x < in.width; ++x) {
      const float ratio = in.rgb(x, 1).g / GREY_CARD;
      if (!toneMap.isLocal() && ratio > 0.965f && ratio < 1.036f) {
        EXPECT_NEAR(out.rgb(x, 1).g / in.rgb(x, 1).g, 1, 0.03f);
      }
    }
  });
}

TEST(ToneMaps, GreyStaysGreyAndNothingIsNegativeOrNotFinite) {
  forEachToneMap([](const ToneMap& toneMap) {
    const Image out = mapped(toneMap, ramp());
    for (int x = 0; x < out.width; ++x) {
      const Rgb c = out.rgb(x, 2);
      EXPECT_NEAR(c.r, c.g, 1e-5f * (1 + c.g));
      EXPECT_NEAR(c.b, c.g, 1e-5f * (1 + c.g));
    }
    const Image colours = mapped(toneMap, pictureOf(64, 64, [](float x, float y) {
                                   return Rgb(std::exp2(16 * x - 8), 0, std::exp2(16 * y - 12));
                                 }));
    for (float v : colours.pixels) ASSERT_TRUE(v >= 0 && v < 1e4f) << v;
  });
}

TEST(ToneMaps, BrighterLightNeverBecomesDarker) {
  forEachToneMap([](const ToneMap& toneMap) {
    if (!toneMap.isLocal()) {
      const Image out = mapped(toneMap, ramp());
      for (int x = 1; x < out.width; ++x) EXPECT_GE(out.rgb(x, 0).g, out.rgb(x - 1, 0).g * (1 - 1e-6f)) << x;
    }
    float before = 0;
    for (float y = 1e-4f; y < 1e3f; y *= 1.3f) { // whole pictures, because of local operators
      const float now = mapped(toneMap, uniform(Rgb(y))).rgb(12, 8).g;
      EXPECT_GE(now, before * (1 - 1e-5f)) << y;
      before = now;
    }
  });
}

TEST(ToneMaps, OnlyThoseThatMeasureThePictureChangeTheRestBesideBrightLight) {
  size_t measuring = 0;
  forEachToneMap([&](const ToneMap& toneMap) {
    if (toneMap.isLocal() && !toneMap.measuresPicture())
      return; // depends on neighbours, not on the whole picture
    const auto beside = [&](float light) {
      return mapped(toneMap, pictureOf(64, 8, [&](float x, float) { return Rgb(x < 0.9f ? 1 : light); }))
          .rgb(0, 4)
          .g;
    };
    const float change = std::abs(beside(1000) / beside(1) - 1);
    EXPECT_EQ(change > 0.001f, toneMap.measuresPicture()) << change;
    measuring += toneMap.measuresPicture();
  });
  EXPECT_GE(measuring, 3u);
}

TEST(ToneMaps, DoNotDependOnTheSizeOfThePicture) {
  const auto scene = [](float x, float y) {
    const float shade = 1 + 0.3f * std::sin(20 * x) * std::cos(15 * y);
    return Rgb(0.9f, 0.7f, 0.4f) * shade * (x + 0.3f * y < 0.6f ? 0.05f : 4.0f);
  };
  forEachToneMap([&](const ToneMap& toneMap) {
    const Image small = mapped(toneMap, pictureOf(150, 100, scene));
    const Image large = mapped(toneMap, pictureOf(450, 300, scene));
    for (int y = 0; y < small.height; y += 7)
      for (int x = 0; x < small.width; x += 3) {
        if (std::abs(float(x) / 150 + 0.3f * float(y) / 100 - 0.6f) < 0.02f) continue; // pixels on the edge
        const float a = small.rgb(x, y).g, b = large.rgb(3 * x + 1, 3 * y + 1).g;
        ASSERT_NEAR(a, b, 0.03f * std::max(a, b)) << x << " " << y;
      }
  });
}

TEST(ToneMaps, HaloesBesideAnEdgeStayBelowTheStatedBound) {
  forEachToneMap([](const ToneMap& toneMap) {
    const Image out =
        mapped(toneMap, pictureOf(1000, 3, [](float x, float) { return Rgb(x < 0.5f ? 0.03f : 3.0f); }));
    const float dark = out.rgb(5, 1).g, bright = out.rgb(994, 1).g;
    EXPECT_GT(bright, dark);
    float worst = 0;
    for (int x = 0; x < 1000; ++x) {
      const float far = x < 500 ? dark : bright;
      worst = std::max(worst, std::abs(out.rgb(x, 1).g - far) / far);
    }
    EXPECT_LE(worst, toneMap.haloBound() + 1e-5f);
  });
}

TEST(ToneMaps, SaturatedLightKeepsItsLuminanceInsideOfTheGamut) {
  const Rgb blue = withLuminance(Rgb(0, 0.1f, 1), 0.5f);
  EXPECT_LE(maxComponent(blue), 1.00001f);
  EXPECT_NEAR(luminance(blue), 0.5f, 1e-5f);
  EXPECT_GT(blue.b, blue.r);
}

TEST(ToneMaps, LocalOperatorsKeepDetailWhereContrastIsReduced) {
  // Ripples of 5 % on two planes with a ratio of 1000, which no single curve preserves together.
  const auto rippled = [](float x, float) {
    return Rgb((x < 0.5f ? 0.02f : 20.0f) * (1 + 0.05f * std::sin(6.2831853f * 25 * x)));
  };
  const auto contrast = [](const Image& p, int x0, int x1) {
    float low = INFINITY, high = 0;
    for (int x = x0; x < x1; ++x) {
      low = std::min(low, p.rgb(x, 1).g);
      high = std::max(high, p.rgb(x, 1).g);
    }
    return (high - low) / (high + low);
  };
  const Image durand = mapped(*makeToneMap("durand"), pictureOf(1000, 3, rippled));
  EXPECT_NEAR(contrast(durand, 100, 400), 0.05f, 0.01f);
  EXPECT_NEAR(contrast(durand, 600, 900), 0.05f, 0.01f);
  EXPECT_LT(durand.rgb(750, 1).g / durand.rgb(250, 1).g, 100);
  const Image global = mapped(*makeToneMap("reinhard"), pictureOf(1000, 3, rippled));
  const Image local = mapped(*makeToneMap("dodgeburn"), pictureOf(1000, 3, rippled));
  EXPECT_GT(contrast(local, 600, 900), contrast(global, 600, 900));
}

TEST(ToneMaps, CurvesAreThePublishedOnes) {
  // Reinhard et al. 2002, equation 4: white is mapped to white; without white L / (1 + L).
  const Image white = mapped(*makeToneMap("reinhard", "\"float white\" 4"), uniform(Rgb(4)));
  EXPECT_NEAR(white.rgb(0, 0).g, 1, 1e-5f);
  const Image half = mapped(*makeToneMap("reinhard", "\"float white\" 100000"), uniform(Rgb(1 - GREY_CARD)));
  EXPECT_NEAR(half.rgb(0, 0).g, 0.5f, 1e-4f);
  // Hable 2010: the linear white point 11.2 is mapped to white. The grey card is at x = 0.52695.
  const auto filmic = [](float y) { return mapped(*makeToneMap("filmic"), uniform(Rgb(y))).rgb(0, 0).g; };
  float x = 0;
  for (; filmic(x) < 1; x += 0.01f) {
  }
  EXPECT_NEAR(x, 11.2f * GREY_CARD / 0.52695f, 0.02f);
  // Drago et al. 2003: the brightest value is mapped to white.
  EXPECT_NEAR(mapped(*makeToneMap("drago"), uniform(Rgb(30))).rgb(0, 0).g, 1, 1e-4f);
  // Narkowicz 2016: the curve at 1 is 2.54 / 3.16, after the scale that preserves the grey card.
  const auto aces = [](float v) { return v * (2.51f * v + 0.03f) / (v * (2.43f * v + 0.59f) + 0.14f); };
  const float scale = greyKeepingScale(aces);
  EXPECT_NEAR(aces(scale * GREY_CARD), GREY_CARD, 1e-6f);
  EXPECT_NEAR(mapped(*makeToneMap("aces"), uniform(Rgb(1 / scale))).rgb(0, 0).g, 2.54f / 3.16f, 1e-4f);
}

TEST(ToneMaps, BlurIsTheGaussianAndKeepsConstants) {
  constexpr int N = 401;
  for (float sigma : {1.5f, 25.0f}) {
    std::vector<float> point(size_t(N) * N), constant(size_t(N) * N, 3.0f);
    point[size_t(N) * 200 + 200] = 1;
    const std::vector<float> blurred = gaussianBlur(point, N, N, sigma);
    for (const int d : {0, 1, 2, 3}) {
      const float r = std::round(float(d) * sigma);
      const float expected = std::exp(-r * r / (2 * sigma * sigma)) / (2 * PI * sigma * sigma);
      const float peak = 1 / (2 * PI * sigma * sigma);
      EXPECT_NEAR(blurred[size_t(N) * 200 + 200 + size_t(r)], expected, 0.04f * peak) << sigma << " " << d;
    }
    for (float v : gaussianBlur(constant, N, N, sigma)) ASSERT_NEAR(v, 3, 1e-4f);
  }
}
