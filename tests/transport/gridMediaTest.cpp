/** @file
 * Media on grids and from noise: bounds, shape, emission.
 */
#include <filesystem>
#include <random>

#include "model/nanoVdbTesting.h"
#include "recurse/scene/parameters/spectrum.h"
#include "rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

std::unique_ptr<Medium> makeMedium(const std::string& name, const std::string& parameters,
                                   Diagnostics& diagnostics) {
  return plugIns().media.make(parseParameterText(name, parameters), MediumContext(), diagnostics);
}

Vec3f pointIn(std::mt19937& random, float low, float high) {
  std::uniform_real_distribution<float> u(low, high);
  const float x = u(random), y = u(random);
  return {x, y, u(random)};
}

/** The extinction at each point of a ray is at most the bound of its segment. */
void expectBounded(const Medium& medium, const std::string& what) {
  std::mt19937 random(5);
  int met = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3f from = pointIn(random, -2, 3);
    const Ray ray{from, glm::normalize(pointIn(random, -1, 2) - from), 5, 0};
    MajorantSegments segments = medium.segments(ray, 5);
    for (MajorantSegment s; segments.next(s); ++met)
      for (const float part : {0.01f, 0.3f, 0.6f, 0.99f}) {
        const Rgb extinction = medium.at(ray.at(s.begin + (s.end - s.begin) * part)).extinction();
        for (int c = 0; c < 3; ++c) ASSERT_LE(extinction[c], s.majorant[c] * 1.0001f) << what;
      }
  }
  EXPECT_GT(met, 50) << what;
}

} // namespace

TEST(GridMedia, BoundsHoldEverywhere) {
  for (const auto& entry : plugIns().media.entries())
    for (const std::string& example : entry.examples) {
      Diagnostics diagnostics;
      const auto medium = makeMedium(entry.name, example, diagnostics);
      ASSERT_TRUE(medium) << entry.name << " " << example << diagnostics.format();
      expectBounded(*medium, entry.name + " " + example);
    }
}

TEST(GridMedia, ACloudIsFullAtItsBottom) {
  Diagnostics diagnostics;
  const auto cloud = makeMedium(
      "cloud",
      "\"point3 p0\" [-1 -1 -1] \"point3 p1\" [1 1 1] \"rgb sigma_s\" [2 3 4] \"rgb sigma_a\" [1 0 0]",
      diagnostics);
  std::mt19937 random(7);
  double low = 0, high = 0;
  for (int i = 0; i < 500; ++i) {
    Vec3f p = pointIn(random, -0.99f, 0.99f);
    p.y = -std::abs(p.y);
    EXPECT_EQ(cloud->at(p).extinction(), Rgb(3, 3, 4));
    p.y = 0.55f;
    low += double(cloud->at(p).scattering.g) / 500;
    p.y = 0.95f;
    high += double(cloud->at(p).scattering.g) / 500;
  }
  EXPECT_LT(high, 0.5 * low);
  EXPECT_GT(low, 0.1);
  EXPECT_EQ(cloud->at({0, -1.01f, 0}).extinction(), BLACK);
}

TEST(GridMedia, WhatIsHotGlows) {
  // One cell, wide enough for the medium to be constant in the visible region.
  const double kelvin = 3000;
  const Rgbd expected =
      rgbOfBlackbody(kelvin, SpectrumKind::ILLUMINANT) *
      (luminance(rgbOfBlackbody(kelvin, SpectrumKind::UNBOUNDED)) * 2 * (1 - std::exp(-1.5)));
  const std::string text =
      view(2, "0 0 -1  0 0 1  0 1 0", 0.1) +
      "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"point3 p0\" [-9000 -9000 -9000] \"point3 "
      "p1\" "
      "[9000 9000 9000] \"float density\" 1 \"float temperature\" 1600 \"float temperatureoffset\" 100 "
      "\"float temperaturescale\" 2 \"float Lescale\" 2 \"rgb sigma_a\" [1.5 1.5 1.5] \"rgb sigma_s\" [0 "
      "0 0]\n"
      "MediumInterface \"m\" \"\"\nMaterial \"interface\"\nShape \"box\" \"point3 p1\" [-2 -2 0] "
      "\"point3 p2\" "
      "[2 2 1]\n";
  for (const char* integrator : {"path", "photonmap"}) {
    const Rendered r = renderText(text, integrator, "", samples(4096));
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(double(r.value(0)[c]) / expected[c], 1, SANITIZED ? 0.2 : 0.05) << integrator << " " << c;
    // Photons contribute nothing here: the first pass shows this, and no more are shot.
    EXPECT_LT(r.statistics.photonsEmitted, 200000u) << integrator;
  }
}

TEST(GridMedia, CellsHaveTheirOwnScaleOfLight) {
  for (const char* light : {"\"rgb Le\" [1 2 3]", "\"float temperature\" [3000 3000]"}) {
    const std::string common = std::string("\"integer nx\" 2 \"float density\" [1 1] ") + light + " ";
    Diagnostics diagnostics;
    const auto one = makeMedium("uniformgrid", common, diagnostics);
    const auto each = makeMedium("uniformgrid", common + "\"float Lescale\" [0 4]", diagnostics);
    ASSERT_FALSE(diagnostics.hasErrors()) << diagnostics.format();
    const auto ratio = [&](const Vec3f& p) { return each->at(p).emission.g / one->at(p).emission.g; };
    EXPECT_EQ(each->at({.25f, .5f, .5f}).emission, BLACK);
    EXPECT_NEAR(ratio({.75f, .5f, .5f}), 4, 1e-5);
    EXPECT_NEAR(ratio({.5f, .5f, .5f}), 2, 1e-5);
  }
  Diagnostics diagnostics;
  makeMedium("uniformgrid", "\"integer nx\" 2 \"float density\" [1 1] \"float Lescale\" [1 2 3]",
             diagnostics);
  EXPECT_NE(diagnostics.format().find("3 values for 2 x 1 x 1 cells"), std::string::npos);
}

namespace {

/** Grid whose density varies along x and is constant along the other axes. */
WrittenGrid layers(const std::string& name, int cells, float value) {
  WrittenGrid g;
  g.name = name;
  for (int x = 0; x < cells; ++x)
    for (int y = -8; y < 8; ++y)
      for (int z = -8; z < 8; ++z) g(x, y, z) = value * static_cast<float>(1 + x);
  return g;
}

} // namespace

TEST(GridMedia, NanoVdbIsTheMediumOfItsGrid) {
  WrittenGrid grid = layers("density", 8, 0.5f);
  grid.voxel = 0.125;
  grid.origin = {-0.5, 0, 0};
  const NanoVdbFile file({grid});
  Diagnostics diagnostics;
  const auto medium =
      makeMedium("nanovdb", file.parameter() + "\"rgb sigma_s\" [1 2 3] \"float scale\" 2", diagnostics);
  ASSERT_TRUE(medium) << diagnostics.format();
  expectBounded(*medium, "nanovdb");
  EXPECT_FALSE(medium->isEmissive());
  // Value 0.5 (1 + x) at x / 8 - 0.5, linear in between; after the last value it decreases to zero.
  for (const double x : {0.0, 0.25, 3.5, 6.75})
    EXPECT_NEAR(double(medium->at({float(x / 8 - 0.5), .2f, -.3f}).scattering.g), 4 * 0.5 * (1 + x), 1e-5);
  EXPECT_NEAR(double(medium->at({7.75f / 8 - 0.5f, 0, 0}).scattering.r), 2 * 4 * 0.25, 1e-5);
  EXPECT_EQ(medium->at({8.1f / 8 - 0.5f, 0, 0}).extinction(), BLACK);
  EXPECT_EQ(medium->at({-0.51f, 0, 0}).extinction(), BLACK);
}

TEST(GridMedia, NanoVdbLetsThroughWhatItsDensityDoes) {
  WrittenGrid grid = layers("density", 8, 0.25f);
  const NanoVdbFile file({grid});
  // Along x: whole cells of densities 0.25, 0.5 … 2, linear in between, and down to 0 after the last.
  double thickness = 0;
  for (int x = 0; x < 8; ++x) thickness += 0.25 * (1 + x + (x < 7 ? 2 + x : 0)) / 2;
  const Rendered r = renderText(
      view(2, "-3 0 0  1 0 0  0 0 1", 0.1) +
          "LightSource \"infinite\" \"rgb L\" [1 1 1]\nMakeNamedMedium \"m\" \"string type\" \"nanovdb\" " +
          file.parameter() +
          "\"rgb sigma_a\" [.3 .3 .3] \"rgb sigma_s\" [0 0 0]\n"
          "MediumInterface \"m\" \"\"\nMaterial \"interface\"\nShape \"sphere\" \"float radius\" 40\n",
      "path", "", samples(1 << 16));
  EXPECT_NEAR(r.mean(), std::exp(-0.3 * thickness), 4 * r.standardError());
  EXPECT_LT(r.standardError(), (SANITIZED ? 0.03 : 0.008) * r.mean());
}

TEST(GridMedia, NanoVdbGlowsByItsTemperatures) {
  const NanoVdbFile file({layers("density", 8, 1), layers("temperature", 8, 400)});
  Diagnostics diagnostics;
  const auto medium = makeMedium("nanovdb", file.parameter() + "\"rgb sigma_s\" [0 0 0]", diagnostics);
  ASSERT_TRUE(medium) << diagnostics.format();
  EXPECT_TRUE(medium->isEmissive());
  const double kelvin = 400 * 5.5;
  const Rgbd expected = rgbOfBlackbody(kelvin, SpectrumKind::ILLUMINANT) *
                        (5.5 * double(luminance(rgbOfBlackbody(kelvin, SpectrumKind::UNBOUNDED))));
  const Rgb found = medium->at({4.5f, 0, 0}).emission;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(double(found[c]) / expected[c], 1, 0.01) << c;
  const auto twice =
      makeMedium("nanovdb", file.parameter() + "\"rgb sigma_s\" [0 0 0] \"float LeScale\" 2", diagnostics);
  ASSERT_TRUE(twice) << diagnostics.format();
  EXPECT_NEAR(twice->at({4.5f, 0, 0}).emission.g / found.g, 2, 1e-5);
}

TEST(GridMedia, NanoVdbFilesThatDoNotDoAreNamed) {
  const auto errorOf = [](const NanoVdbFile& file) {
    Diagnostics diagnostics;
    EXPECT_FALSE(makeMedium("nanovdb", file.parameter(), diagnostics));
    return diagnostics.format();
  };
  const auto has = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  has(errorOf(NanoVdbFile({layers("fog", 2, 1), layers("flames", 2, 1)})),
      "recurse-smoke.nvdb has no grid \"density\"");
  has(errorOf(NanoVdbFile({layers("fog", 2, 1), layers("flames", 2, 1)})),
      "its grids are \"fog\", \"flames\"");
  has(errorOf(NanoVdbFile({layers("density", 2, 1e20f)})), "too high for single precision");
  {
    const NanoVdbFile cut({layers("density", 2, 1)});
    std::filesystem::resize_file(cut.path, 400);
    has(errorOf(cut), "recurse-smoke.nvdb: ");
  }
  const NanoVdbFile negative({layers("density", 2, -1)});
  Diagnostics diagnostics;
  const auto none = makeMedium("nanovdb", negative.parameter(), diagnostics);
  ASSERT_TRUE(none);
  has(diagnostics.format(), "negative densities are replaced by 0");
  EXPECT_EQ(none->at({1, 0, 0}).extinction(), BLACK);
}
