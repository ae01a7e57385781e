/** @file
 * Developing: exposure of dark, bright and mostly black pictures, and of pictures with lamps in them; white
 * balance, encodings, dither.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

#include <unistd.h>

#include "recurse/core/io/error.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/report/develop/develop.h"
#include "report/develop/bloom.h"
#include "sceneRendering.h"

using namespace recurse;

namespace {

Image filled(int width, int height, const std::function<Rgb(int, int)>& colour) {
  Image image(width, height, {"R", "G", "B"});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Rgb c = colour(x, y);
      for (int i = 0; i < 3; ++i) image.at(x, y)[i] = c[i];
    }
  return image;
}

/** A picture whose luminance is uniformly distributed over two stops around `middle`. */
Image shades(float middle, float scale = 1) {
  return filled(60, 40, [&](int x, int y) {
    return Rgb(scale * middle * std::exp2(2 * (float((x * 7 + y * 13) % 60) + 0.5f) / 60 - 1));
  });
}

DevelopSettings plain() {
  DevelopSettings settings;
  settings.exposure = {Exposure::Meter::NONE, 0, 0};
  return settings;
}

std::shared_ptr<const ToneMap> toneMap(const std::string& name) {
  Diagnostics diagnostics;
  return plugIns().toneMaps.make(parseParameterText(name, ""), NoContext{}, diagnostics);
}

/** Picture for the display, without encoding. */
Image shownBy(const std::string& name, const Image& light) {
  DevelopSettings settings = plain();
  settings.toneMap = toneMap(name);
  settings.display = DisplayEncoding("linear");
  return develop(light, settings).picture;
}

/** Picture by the tone operator alone. */
Image byOperator(const std::string& name, Image light) {
  toneMap(name)->apply(light);
  for (float& v : light.pixels) v = std::min(v, 1.0f);
  return light;
}

/** A nearly vertical edge, `bright` on the left; each pixel is the mean over its area. */
Image slantedEdge(float bright, float dark) {
  return filled(96, 96, [&](int x, int y) {
    float covered = 0;
    for (float sub = 0.5f; sub < 16; ++sub)
      covered += std::clamp(44 + 0.0875f * (float(y) + sub / 16) - float(x), 0.0f, 1.0f) / 16;
    return Rgb(dark + covered * (bright - dark));
  });
}

/** Standard deviation of a slanted edge's positions in the rows from a line [pixels]. */
double staircase(const Image& picture) {
  const int n = picture.height;
  const double bright = double(picture.rgb(2, n / 2).g), dark = double(picture.rgb(n - 3, n / 2).g);
  std::vector<double> places;
  double mean = 0, slope = 0, squares = 0, sum = 0;
  for (int y = 0; y < n; ++y) {
    double place = 0;
    for (int x = 0; x < n; ++x) place += (double(picture.rgb(x, y).g) - dark) / (bright - dark);
    places.push_back(place);
    mean += place / n;
  }
  for (int y = 0; y < n; ++y)
    slope += (y - (n - 1) / 2.0) * places[size_t(y)], squares += square(y - (n - 1) / 2.0);
  for (int y = 0; y < n; ++y) sum += square(places[size_t(y)] - mean - slope / squares * (y - (n - 1) / 2.0));
  return std::sqrt(sum / n);
}

} // namespace

TEST(BrightEdges, OfLampsAreAsSmoothAsThoseOfPaper) {
  for (const auto& entry : plugIns().toneMaps.entries()) {
    if (toneMap(entry.name)->isIdentity()) continue;
    EXPECT_LT(staircase(shownBy(entry.name, slantedEdge(0.36f, 0.18f))), 0.03) << entry.name << " paper";
    for (const float lamp : {2.0f, 20.0f, 100.0f, 1e4f})
      EXPECT_LT(staircase(shownBy(entry.name, slantedEdge(lamp, 0.1f))), 0.03) << entry.name << " " << lamp;
  }
  // Paper beside the lamp, itself brighter than white.
  EXPECT_LT(staircase(shownBy("filmic", slantedEdge(60, 1.1f))), 0.03);
  EXPECT_GT(staircase(byOperator("filmic", slantedEdge(100, 0.1f))), 0.15) << "the measure sees nothing";
}

TEST(BrightEdges, OfNarrowLampsAreSmoothToo) {
  // A nearly vertical tube on paper: the sums of all rows of the picture must be equal.
  const auto tube = [](float width, float bright, float paper) {
    return filled(48, 96, [&](int x, int y) {
      float covered = 0;
      for (float sub = 0.5f; sub < 16; ++sub) {
        const float left = 20 + 0.0875f * (float(y) + sub / 16) - float(x);
        covered += std::clamp(left + width, 0.0f, 1.0f) / 16 - std::clamp(left, 0.0f, 1.0f) / 16;
      }
      return Rgb(paper + covered * (bright - paper));
    });
  };
  const auto unevenness = [](const Image& picture) {
    double mean = 0, squares = 0;
    for (int y = 8; y < 88; ++y) {
      double row = 0;
      for (int x = 0; x < 48; ++x) row += double(picture.rgb(x, y).g - picture.rgb(0, y).g);
      mean += row / 80;
      squares += row * row / 80;
    }
    return std::sqrt(std::max(squares - mean * mean, 0.0)) / mean;
  };
  for (const float width : {0.3f, 1.0f, 2.0f, 3.0f})
    for (const float bright : {30.0f, 1000.0f})
      for (const float paper : {0.1f, 1.1f}) {
        const Image light = tube(width, bright, paper);
        const double before = unevenness(byOperator("filmic", light));
        const double after = unevenness(shownBy("filmic", light));
        EXPECT_LT(after, 0.6 * before)
            << width << " " << bright << " " << paper << ": " << after << " of " << before;
      }
}

TEST(BrightEdges, GlareFallsFromALampOnwards) {
  // A round lamp; each pixel is the mean over its area.
  const Image lamp = filled(49, 49, [](int x, int y) {
    float covered = 0;
    for (int i = 0; i < 64; ++i)
      covered += std::hypot(float(x) - 24.3f + float(i % 8) / 8, float(y) - 24.1f + float(i / 8) / 8) < 2.3f;
    return Rgb(0.07f) + covered / 64 * Rgb(2000, 1700, 1200);
  });
  for (const char* name : {"filmic", "aces", "reinhard", "drago"})
    for (const double bloom : {0.03, 0.3}) {
      DevelopSettings settings = plain();
      settings.toneMap = toneMap(name);
      settings.bloom = bloom;
      settings.display = DisplayEncoding("linear");
      const Image shown = develop(lamp, settings).picture;
      Image glaring = lamp;
      applyBloom(glaring, bloom, settings.bloomDegrees);
      glaring = byOperator(name, glaring);
      for (int y = 0; y < 49; ++y)
        for (int x = 0; x < 49; ++x) {
          const std::string place = std::string(name) + " " + std::to_string(bloom) + " " +
                                    std::to_string(x) + " " + std::to_string(y);
          if (lamp.rgb(x, y).r < 0.1f) { // the glare beside the lamp is no edge
            EXPECT_EQ(shown.rgb(x, y).g, glaring.rgb(x, y).g) << place;
            continue;
          }
          // No pixel of the edge is darker than a pixel farther out.
          const int outwards = x > 24 ? x + 1 : x - 1;
          EXPECT_GE(shown.rgb(x, y).g, std::min(shown.rgb(outwards, y).g, shown.rgb(24, 24).g)) << place;
        }
    }
}

TEST(BrightEdges, StaySmoothInGlare) {
  DevelopSettings settings = plain();
  settings.toneMap = toneMap("filmic");
  settings.bloom = 0.02;
  settings.display = DisplayEncoding("linear");
  EXPECT_LT(staircase(develop(slantedEdge(20, 0.1f), settings).picture), 0.03);
}

TEST(BrightEdges, ColouredLampsKeepTheirColourBesideTheEdge) {
  const auto lamp = [](float covered) {
    return covered * Rgb(80, 20, 2) + (1 - covered) * Rgb(0.1f, 0.1f, 0.3f);
  };
  const Image light = filled(32, 32, [&](int x, int) {
    return lamp(x < 16 ? 1.0f : x == 16 ? 0.25f : 0.0f);
  });
  const Image shown = shownBy("filmic", light);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(shown.rgb(16, 16)[c], 0.25f * shown.rgb(8, 16)[c] + 0.75f * shown.rgb(24, 16)[c], 1e-4f) << c;
}

TEST(BrightEdges, NothingElseChanges) {
  const auto unchanged = [](const Image& light, float most) {
    const Image a = shownBy("filmic", light), b = byOperator("filmic", light);
    for (size_t i = 0; i < a.pixels.size(); ++i) ASSERT_NEAR(a.pixels[i], b.pixels[i], most) << i;
  };
  unchanged(filled(100, 8, [](int x, int) { return Rgb(0.01f * std::pow(1.1f, float(x))); }), 0.01f);
  unchanged(filled(64, 64, [](int x, int y) { return Rgb((x * 37 + y * 61) % 89 == 0 ? 60 : 0.2f); }), 1e-6f);
  unchanged(slantedEdge(0.9f, 0.05f), 1e-6f);
  // A steep slope up to a lamp; and bright noise beside dark pixels.
  unchanged(
      filled(40, 16, [](int x, int) { return Rgb(std::min(100.0f, 0.01f * std::pow(1.6f, float(x)))); }),
      1e-6f);
  unchanged(filled(64, 64,
                   [](int x, int y) {
                     return Rgb(x > 31 ? 0.1f : (x * 7 + y * 5) % 3 == 0 ? 2 : 150);
                   }),
            1e-6f);
  const Image lamp = slantedEdge(100, 0.1f), shown = shownBy("none", lamp), cut = byOperator("none", lamp);
  EXPECT_EQ(shown.pixels, cut.pixels) << "the plain picture";
}

TEST(Metering, LogAverageBecomesMiddleGreyAtAnyBrightness) {
  for (float middle : {1e-6f, 0.01f, 1.0f, 3e4f})
    EXPECT_NEAR(meteredStops(shades(middle)), std::log2(GREY_CARD / middle), 0.05) << middle;
  EXPECT_NEAR(meteredStops(filled(8, 8, [](int, int) { return Rgb(5); })), std::log2(GREY_CARD / 5), 1e-5);
}

TEST(Metering, LampsBlackAndBrokenPixelsDoNotCount) {
  const double stops = meteredStops(shades(0.05f));
  Image lamp = shades(0.05f);
  for (int x = 20; x < 28; ++x)
    for (int y = 2; y < 14; ++y) // four pixels in a hundred
      for (int c = 0; c < 3; ++c) lamp.at(x, y)[c] = 1e5f;
  EXPECT_NEAR(meteredStops(lamp), stops, 0.35);
  // The object in small size in a black picture.
  const Image thing = shades(0.05f);
  const Image mostlyBlack =
      filled(240, 160, [&](int x, int y) { return x < 60 && y < 40 ? thing.rgb(x, y) : BLACK; });
  EXPECT_NEAR(meteredStops(mostlyBlack), stops, 0.02);
  Image broken = shades(0.05f);
  broken.at(3, 3)[0] = std::numeric_limits<float>::infinity();
  broken.at(4, 3)[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NEAR(meteredStops(broken), stops, 0.02);
  EXPECT_EQ(meteredStops(filled(8, 8, [](int, int) { return BLACK; })), 0);
}

TEST(Metering, WhatIsLitIsNotBurntWhereTheRestIsDark) {
  // A patch of a twentieth of the picture, and the room ten stops below it.
  const Image patch = filled(100, 100, [](int x, int y) { return Rgb(x < 25 && y < 24 ? 1.0f : 1e-3f); });
  const double shown = std::exp2(meteredStops(patch));
  EXPECT_LT(shown, 4) << "over the white of the filmic curve";
  EXPECT_GT(shown, 0.1);
}

TEST(Metering, NoiseDoesNotCount) {
  // Light that one path in `rarity` finds, over three stops of luminance, in a black frame, with a lamp.
  const auto noisy = [](int size, int rarity) {
    std::mt19937 random(5);
    return filled(size, size * 2 / 3, [&](int x, int y) {
      if (x < size / 8 || y < size / 10) return BLACK;
      if (x > size * 3 / 4 && x < size * 4 / 5 && y > size / 2) return Rgb(300);
      const float shade = std::exp2(-3.0f * float(x) / float(size));
      return random() % unsigned(rarity) == 0 ? Rgb(shade * float(rarity)) : BLACK;
    });
  };
  for (const int size : {160, 600})
    for (const int rarity : {2, 8})
      EXPECT_NEAR(meteredStops(noisy(size, rarity)), meteredStops(noisy(size, 1)), 0.2)
          << size << " " << rarity;
}

TEST(Metering, FewSamplesAreExposedAsManyAre) {
  // A room lit through a doorway from a second room with a lamp.
  const auto scene =
      recurse::testing::sceneFrom(R"(Film "rgb" "integer xresolution" 180 "integer yresolution" 120
LookAt 0 1 -2.9  0 1 0  0 1 0
Camera "perspective" "float fov" 70
WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [ 20 18 16 ]
  Translate 0 1.5 6
  Shape "sphere" "float radius" .4
AttributeEnd
Material "diffuse" "rgb reflectance" [ .6 .6 .55 ]
Shape "box" "point3 p1" [ -3 0 -3 ] "point3 p2" [ 3 3 9 ]
Shape "box" "point3 p1" [ -3 0 2.9 ] "point3 p2" [ -.6 3 3.1 ]
Shape "box" "point3 p1" [ .6 0 2.9 ] "point3 p2" [ 3 3 3.1 ]
Translate -1 .5 0
Material "diffuse" "rgb reflectance" [ .2 .1 .1 ]
Shape "sphere" "float radius" .5
)");
  const auto stops = [&](int count) {
    const auto integrator = recurse::testing::integratorFrom("path", "\"integer maxdepth\" 5");
    const recurse::testing::Rendered r =
        recurse::testing::renderScene(*scene, *integrator, PathClasses(), count, 1);
    return meteredStops(filled(180, 120, [&](int x, int y) { return r.value(size_t(y) * 180 + size_t(x)); }));
  };
  EXPECT_NEAR(stops(4), stops(recurse::testing::samples(64)), 0.2);
}

TEST(Metering, PercentileComesToWhite) {
  Image ramp = filled(1000, 1, [](int x, int) { return Rgb(float(x + 1) / 100); });
  EXPECT_NEAR(std::exp2(stopsFor({Exposure::Meter::PERCENTILE, 98, 0}, ramp)), 1 / 9.8, 1e-3);
  EXPECT_NEAR(std::exp2(stopsFor({Exposure::Meter::PERCENTILE, 100, 2}, ramp)), 0.4, 1e-3);
}

TEST(Develop, DoesNotDependOnTheSceneUnit) {
  DevelopSettings settings;
  settings.toneMap = toneMap("filmic");
  const Developed a = develop(shades(0.3f), settings), b = develop(shades(0.3f, 1e5f), settings);
  for (size_t i = 0; i < a.picture.pixels.size(); ++i)
    ASSERT_NEAR(a.picture.pixels[i], b.picture.pixels[i], 1e-4f);
  EXPECT_NEAR(a.stops - b.stops, std::log2(1e5), 1e-3);
}

TEST(Develop, PlainIsTheSrgbEncodingAndFileValues) {
  const Image in = filled(64, 1, [](int x, int) { return Rgb(float(x) / 50, 0.002f, -1); });
  const Image out = develop(in, plain()).picture;
  for (int x = 0; x < 64; ++x) {
    const float linear = std::min(float(x) / 50, 1.0f);
    EXPECT_NEAR(out.rgb(x, 0).r,
                linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f, 1e-6f);
    EXPECT_NEAR(out.rgb(x, 0).g, 12.92f * 0.002f, 1e-6f);
    EXPECT_EQ(out.rgb(x, 0).b, 0);
  }
  const std::string folder =
      (std::filesystem::temp_directory_path() / ("recurse-develop-" + std::to_string(::getpid()))).string();
  std::filesystem::create_directories(folder);
  writeImage(folder + "/a.png", out, {.encoded = true});
  writeImage(folder + "/b.png", in);
  EXPECT_EQ(readImage(folder + "/a.png").pixels, readImage(folder + "/b.png").pixels);
  std::filesystem::remove_all(folder);
}

TEST(Develop, EncodingsAreThePublishedOnes) {
  const Image in = filled(3, 1, [](int x, int) { return Rgb(float(x) / 2); });
  const auto middle = [&](const std::string& name) {
    DevelopSettings settings = plain();
    settings.display = DisplayEncoding(name);
    const Image out = develop(in, settings).picture;
    EXPECT_EQ(out.rgb(0, 0), BLACK) << name;
    EXPECT_NEAR(out.rgb(2, 0).g, 1, 1e-5f) << name;
    return out.rgb(1, 0).g;
  };
  EXPECT_NEAR(middle("linear"), 0.5f, 1e-6f);
  EXPECT_NEAR(middle("gamma2.2"), 0.72974f, 1e-4f);
  EXPECT_NEAR(middle("gamma1.8"), 0.68040f, 1e-4f);
  EXPECT_NEAR(middle("rec1886"), 0.74915f, 1e-4f);
  EXPECT_NEAR(middle("rec709"), 0.70551f, 1e-4f);
  EXPECT_NEAR(middle("srgb"), 0.73536f, 1e-4f);
  EXPECT_THROW(DisplayEncoding("gama2.2"), Error);
}

TEST(Develop, WhiteBalanceMakesTheLightWhite) {
  // Chromaticities of the light as tabulated: CIE A (2856 K), and daylight D50 (5003 K) and D75 (7504 K).
  struct Light {
    double kelvin, x, y;
  };
  for (const Light& light :
       {Light{2856, 0.44758, 0.40745}, {5003, 0.34567, 0.35850}, {7504, 0.29902, 0.31485}}) {
    const double X = light.x / light.y, Z = (1 - light.x - light.y) / light.y;
    const Rgb colour(float(3.2409699 * X - 1.5373832 - 0.4986108 * Z),
                     float(-0.9692436 * X + 1.8759675 + 0.0415551 * Z),
                     float(0.0556301 * X - 0.2039770 + 1.0569715 * Z));
    Image picture = filled(4, 4, [&](int, int) { return colour; });
    applyWhiteBalance(picture, {false, light.kelvin});
    const Rgb balanced = picture.rgb(1, 1);
    EXPECT_NEAR(balanced.r, 1, 0.02f) << light.kelvin;
    EXPECT_NEAR(balanced.g, 1, 0.02f) << light.kelvin;
    EXPECT_NEAR(balanced.b, 1, 0.03f) << light.kelvin;
  }
  Image neutral = filled(4, 4, [](int, int) { return Rgb(0.3f, 0.5f, 0.2f); });
  applyWhiteBalance(neutral, {false, 6504});
  EXPECT_NEAR(neutral.rgb(0, 0).r, 0.3f, 0.003f);
  EXPECT_NEAR(neutral.rgb(0, 0).b, 0.2f, 0.003f);
  Image yellow = filled(9, 9, [](int x, int) { return Rgb(0.9f, 0.6f, 0.2f) * (0.5f + 0.1f * float(x)); });
  applyWhiteBalance(yellow, {true, 0});
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(yellow.rgb(4, 4)[c], luminance(Rgb(0.9f, 0.6f, 0.2f)) * 0.9f, 0.01f) << c;
}

TEST(Develop, DitherKeepsTheMeanAndBlackAndWhite) {
  DevelopSettings settings = plain();
  settings.display = DisplayEncoding("linear");
  settings.dither = true;
  const float level = 100.3f / 255; // between two steps
  const Image out =
      develop(filled(64, 64, [&](int x, int) { return x < 2   ? BLACK
                                                      : x < 4 ? Rgb(1)
                                                              : Rgb(level); }),
              settings)
          .picture;
  double sum = 0;
  int differing = 0;
  for (int y = 0; y < 64; ++y) {
    EXPECT_EQ(out.rgb(0, y), BLACK);
    EXPECT_EQ(out.rgb(3, y), Rgb(1));
    for (int x = 4; x < 64; ++x) {
      const double step = std::round(255 * double(out.rgb(x, y).g));
      EXPECT_LE(std::abs(step - 100.5), 0.5);
      differing += step != 100;
      sum += step / (60 * 64);
    }
  }
  EXPECT_NEAR(sum, 100.3, 0.02);
  EXPECT_GT(differing, 0);
}

TEST(OperatorSheet, PixelsThatAreNotFiniteDoNotSpoilTheirBlocks) {
  Image picture(482, 8, {"R", "G", "B"}); // blocks of 2 x 2 pixels
  std::fill(picture.pixels.begin(), picture.pixels.end(), 0.5f);
  const DevelopSettings settings;
  const Image expected = operatorSheet(picture, settings).picture;
  picture.at(100, 3)[1] = NAN;
  picture.at(301, 6)[0] = INFINITY;
  EXPECT_EQ(operatorSheet(picture, settings).picture.pixels, expected.pixels);
}
