/** @file
 * Directions of light at a point: drawn densities integrate to one, drawn light agrees with form factors.
 */
#include <gtest/gtest.h>

#include "guidedScenes.h"
#include "recurse/report/directions/guideFigure.h"
#include "report/directions/hemisphereDisc.h"

namespace recurse {
namespace {

using namespace recurse::testing;

constexpr double HOLE = 0.3;

GuideFigure directionsIn(const std::string& text, int64_t samples, std::array<int, 2> pixel = {1, 1},
                         const std::string& integrator = "\"bool guided\" true") {
  const auto scene = sceneFrom(text);
  const auto path = integratorFrom("path", integrator);
  const std::atomic<bool> stop{false};
  return guideFigure(*scene, *path, {pixel}, 6, samples, 3, stop);
}

/** Directions below a hole, recorded once; the guide no longer exists. */
const PixelDirections& belowHole() {
  static const GuideFigure figure = directionsIn(floorBelowHole(HOLE), 16);
  return figure.pixels[0];
}

TEST(HemisphereDisc, HasEqualAreasForEqualSolidAngles) {
  const HemisphereDisc disc(glm::normalize(Vec3f(1, 2, 3)), {0, 0, 1});
  double moment = 0, angle = 0; // moment of the cosine over the hemisphere: 1/2 of its solid angle
  for (size_t cell = 0; cell < size_t(square(HemisphereDisc::CELLS)); ++cell)
    if (const auto d = disc.direction(cell, Vec2f(0.5f))) {
      EXPECT_NEAR(glm::length(*d), 1, 1e-5f);
      EXPECT_EQ(disc.cellOf(*d), cell);
      moment += HemisphereDisc::CELL_ANGLE * double(disc.cosine(*d));
      angle += HemisphereDisc::CELL_ANGLE;
    }
  EXPECT_NEAR(angle, 2 * PI_D, 1e-2); // cells at the rim are either inside or outside
  EXPECT_NEAR(moment, PI_D, 1e-2);
  EXPECT_EQ(disc.cellOf(-glm::normalize(Vec3f(1, 2, 3))), std::nullopt);
}

TEST(HemisphereDisc, HasTheCameraAtTheBottom) {
  const HemisphereDisc disc({0, 0, 1}, {1, 0, 0.5f});
  const auto rowOf = [&](const Vec3f& d) { return *disc.cellOf(glm::normalize(d)) / HemisphereDisc::CELLS; };
  EXPECT_GT(rowOf({1, 0, 0.1f}), 90u);
  EXPECT_LT(rowOf({-1, 0, 0.1f}), 5u);
  EXPECT_NEAR(double(rowOf({0, 0, 1})), HemisphereDisc::CELLS / 2.0, 1);
  // Seen from above with x down, y is on the right.
  EXPECT_GT(*disc.cellOf(glm::normalize(Vec3f(0, 1, 0.1f))) % HemisphereDisc::CELLS, 90u);
}

TEST(GuideFigure, DensitiesIntegrateToOne) {
  const PixelDirections& p = belowHole();
  for (int i = 0; i < PixelDirections::DENSITIES; ++i)
    EXPECT_NEAR(p.integral(PixelDirections::Density(i)), 1, 0.01) << i;
}

TEST(GuideFigure, LightThroughAHoleIsItsFormFactor) {
  const double factor = holeFormFactor(HOLE);
  const PixelDirections& p = belowHole();
  EXPECT_EQ(p.pixel, "1,1");
  EXPECT_NEAR(p.irradiance, PI_D * factor * HOLE_RADIANCE, 0.01 * PI_D * factor * HOLE_RADIANCE);
  EXPECT_NEAR(p.leftToRays, 0.5 * factor * HOLE_RADIANCE, 0.01 * 0.5 * factor * HOLE_RADIANCE);
  // Towards the zenith the density is 1 / (π F), beside the hole it is 0.
  constexpr size_t ZENITH =
                       size_t(HemisphereDisc::CELLS) * HemisphereDisc::CELLS / 2 + HemisphereDisc::CELLS / 2,
                   BESIDE = ZENITH + HemisphereDisc::CELLS / 4;
  for (const auto density : {PixelDirections::INCIDENT, PixelDirections::LEFT_TO_RAYS}) {
    EXPECT_NEAR(p.densities[density][ZENITH], 1 / (PI_D * factor),
                (density == PixelDirections::INCIDENT ? 0.01 : 0.3) / (PI_D * factor));
    EXPECT_EQ(p.densities[density][BESIDE], 0);
  }
  EXPECT_NEAR(p.densities[PixelDirections::BSDF][ZENITH], 1 / PI_D, 0.01 / PI_D);
}

TEST(GuideFigure, VarianceIsThatOfTheClosedForm) {
  // Cosine sampling of a fraction F: 1/F - 1. A perfect guide, sampled with probability 1 - a: see
  // GuideField.AWindowsLightHasHardlyMoreVarianceThanByAPerfectGuide.
  const double factor = holeFormFactor(HOLE), a = 0.5, perfect = a * (1 - factor) / (1 - a + a * factor);
  const PixelDirections& p = belowHole();
  EXPECT_NEAR(p.bsdfVariance, 1 / factor - 1, 0.05 / factor);
  EXPECT_TRUE(p.learned.isSampled);
  EXPECT_GT(p.learned.records, 100u);
  EXPECT_GT(p.mixtureVariance, 0.98 * perfect);
  EXPECT_LT(p.mixtureVariance, 1.75 * perfect);
}

TEST(GuideFigure, SaysWhereTheGuideIsOff) {
  const GuideFigure figure = directionsIn(floorBelowHole(0), 1);
  const PixelDirections& p = figure.pixels[0];
  EXPECT_FALSE(p.learned.isSampled);
  ASSERT_NE(p.learned.guide, nullptr) << "the density is shown, but is not sampled";
  EXPECT_LT(p.bsdfVariance, 0.01) << "cosine sampling is perfect below an even sky";
  EXPECT_GT(p.mixtureVariance, p.bsdfVariance);
  EXPECT_EQ(figure.guide.cellsOn, 0u);
  EXPECT_NEAR(figure.guide.gain, 1, 0.1);
  const std::vector<FigurePanel> panels = guidePanels(figure);
  ASSERT_EQ(panels.size(), size_t(PixelDirections::DENSITIES));
  EXPECT_TRUE(panels[PixelDirections::GUIDE].name.starts_with("guide, off: ")) << panels[2].name;
  EXPECT_TRUE(panels[PixelDirections::MIXTURE].name.starts_with("mixture")) << panels[4].name;
}

TEST(GuideFigure, IndirectLightIsAllLeftToRays) {
  // No ray can hit the point light: rays find only the light that the wall reflects.
  const std::string scene = view(8, 8, "0 1 -3  0 0 0  0 1 0", perspective(1)) +
                            "LightSource \"point\" \"rgb I\" [ 5 5 5 ] \"point3 from\" [ 1 1 0 ]\n"
                            "Material \"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]\n"
                            "Shape \"bilinearmesh\" \"point3 P\" [ -9 0 -9  9 0 -9  -9 0 9  9 0 9 ]\n"
                            "Shape \"bilinearmesh\" \"point3 P\" [ 2 0 -9  2 9 -9  2 0 9  2 9 9 ]\n";
  const GuideFigure figure = directionsIn(scene, 16);
  const PixelDirections& p = figure.pixels[0];
  EXPECT_NEAR(p.leftToRays, 0.5 / PI_D * p.irradiance, 0.02 * p.leftToRays);
}

TEST(GuideFigure, RefusesWhatHasNoGuide) {
  EXPECT_THROW(directionsIn(floorBelowHole(HOLE), 1, {1, 1}, ""), Error);
  const std::string mirror = view(8, 8, "0 0 -3  0 0 0  0 1 0", perspective(1)) +
                             "LightSource \"infinite\"\nMaterial \"conductor\" \"rgb reflectance\" [1 1 1]\n"
                             "Shape \"bilinearmesh\" \"point3 P\" [-9 -9 0  9 -9 0  -9 9 0  9 9 0]\n";
  EXPECT_THROW(directionsIn(mirror, 1), Error); // only the sky is visible
}

} // namespace
} // namespace recurse
