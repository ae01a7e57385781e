/** @file
 * Media on grids and by noise: bounds, shape, glow.
 */
#include <random>

#include "recurse/scene/spectrum.h"
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

/** No point of a ray has more extinction than the segment that it lies in. */
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
  // One cell so wide that the medium is even where it is seen.
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
  }
}
