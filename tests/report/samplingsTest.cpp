/** @file
 * Figures of direct light: each sampling agrees with closed forms, and offsets of shadow rays cause the
 * errors that geometry predicts.
 */
#include <gtest/gtest.h>

#include "recurse/report/figures/figures.h"
#include "sceneRendering.h"

namespace recurse {
namespace {

using namespace recurse::testing;

const std::vector<std::string> SAMPLING_NAMES = {"uniform", "cosine", "BSDF", "light", "BSDF and light"};

SamplingsFigure samplingsOf(const Scene& scene, int64_t samples, uint64_t seed = 5) {
  const std::atomic<bool> stop{false};
  return samplingsFigure(scene, samples, seed, stop);
}

/** A floor seen from above under a uniform sky of radiance 1. */
std::string floorUnderSky(int size) {
  return view(size, size, "0 5 0  0 0 0  0 0 1", perspective(30)) +
         "LightSource \"infinite\" \"rgb L\" [ 1 1 1 ]\nMaterial \"diffuse\" \"rgb reflectance\" [ .5 .5 .5 "
         "]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [ -9 0 -9  -9 0 9  9 0 -9  9 0 9 ]\n";
}

/** A point of a floor, below the middle of a disc of radius 1 and radiance 1 at height 1: E = π/2. The camera
 * looks from the side. */
std::string floorUnderDisc(const std::string& material = "\"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]") {
  return view(1, 1, "0 .5 -3  0 0 0  0 1 0", perspective(1)) +
         "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\nMaterial \"diffuse\" \"rgb "
         "reflectance\" [ 0 0 0 ]\nTranslate 0 1 0\nRotate 90 1 0 0\nShape "
         "\"disk\"\nAttributeEnd\nMaterial " +
         material + "\nShape \"bilinearmesh\" \"point3 P\" [ -9 0 -9  -9 0 9  9 0 -9  9 0 9 ]\n";
}

TEST(Samplings, HaveTheNamesOfTextbooks) {
  const SamplingsFigure figure = samplingsOf(*sceneFrom(floorUnderSky(1)), 2);
  ASSERT_EQ(figure.panels.size(), SAMPLING_NAMES.size());
  for (size_t s = 0; s < SAMPLING_NAMES.size(); ++s) {
    EXPECT_EQ(figure.plot.curves[s].name, SAMPLING_NAMES[s]);
    EXPECT_TRUE(figure.panels[s].name.starts_with(SAMPLING_NAMES[s]));
  }
  EXPECT_EQ(figure.plot.slope, -0.5);
}

TEST(Samplings, AllFindTheIrradianceOfADisc) {
  const double expected = 0.5 / PI_D * PI_D / 2;
  const int64_t samples = 40000;
  const SamplingsFigure figure = samplingsOf(*sceneFrom(floorUnderDisc()), samples);
  for (size_t s = 0; s < SAMPLING_NAMES.size(); ++s)
    EXPECT_NEAR(double(figure.panels[s].image.pixels[0]), expected, 0.025 * expected) << SAMPLING_NAMES[s];
}

TEST(Samplings, ErrorsUnderAnEvenSkyAreThoseOfTheCosine) {
  // Uniform: the estimate over its mean is 2 cos, with the variance 1/3. Cosine, and BSDF in this scene:
  // constant.
  const SamplingsFigure figure = samplingsOf(*sceneFrom(floorUnderSky(40)), 16);
  for (const Vec2d& p : figure.plot.curves[0].points)
    EXPECT_NEAR(p.y, std::sqrt(1 / (3 * p.x)), 0.06 * std::sqrt(1 / (3 * p.x))) << p.x;
  EXPECT_EQ(figure.plot.curves[0].points.size(), 5u); // 1, 2, 4, 8, 16
  EXPECT_LT(figure.plot.curves[1].points.back().y, 2e-3);
  EXPECT_LT(figure.plot.curves[2].points.back().y, 2e-3);
}

TEST(Samplings, CombinedSamplesAreBoundedByBothDensities) {
  // One-sample balance heuristic: the variance under a uniform sky is that of the ratio cos / (cos/2 + p/2),
  // below both.
  const SamplingsFigure figure = samplingsOf(*sceneFrom(floorUnderSky(20)), 4);
  const auto errorOf = [&](size_t s) { return figure.plot.curves[s].points.back().y; };
  EXPECT_GT(errorOf(3), 0.05); // the sky is sampled uniformly
  EXPECT_LT(errorOf(4), errorOf(3));
}

TEST(Samplings, OnlyLightSamplesFindAPointLight) {
  const std::string scene =
      view(2, 2, "0 5 0  0 0 0  0 0 1", perspective(1)) +
      "LightSource \"point\" \"rgb I\" [ 8 8 8 ] \"point3 from\" [ 0 2 0 ]\nMaterial "
      "\"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]\nShape \"bilinearmesh\" \"point3 P\" "
      "[ -9 0 -9  -9 0 9  9 0 -9  9 0 9 ]\n";
  const SamplingsFigure figure = samplingsOf(*sceneFrom(scene), 4096);
  const double expected = 8.0 / 4 * 0.5 / PI_D;
  for (size_t s = 0; s < 3; ++s) {
    EXPECT_EQ(figure.panels[s].image.pixels[0], 0);
    EXPECT_NEAR(figure.plot.curves[s].points.back().y, 1, 0.1); // all light is missing
  }
  EXPECT_NEAR(double(figure.panels[3].image.pixels[0]), expected, 1e-3 * expected);
  EXPECT_NEAR(double(figure.panels[4].image.pixels[0]), expected, 0.06 * expected); // half of the samples
}

TEST(Samplings, AllAreBlackInTheShadow) {
  const std::string blocker = "Shape \"bilinearmesh\" \"point3 P\" [ -9 .9 -2  -9 .9 2  9 .9 -2  9 .9 2 ]\n";
  const SamplingsFigure figure = samplingsOf(*sceneFrom(floorUnderDisc() + blocker), 1000);
  for (const FigurePanel& panel : figure.panels) EXPECT_EQ(panel.image.pixels[0], 0) << panel.name;
}

TEST(Samplings, TransmittedLightIsSampledOnBothSides) {
  // The disc is above the floor, and the camera below it.
  std::string scene = floorUnderDisc("\"diffusetransmission\" \"rgb reflectance\" [ .2 .2 .2 ] \"rgb "
                                     "transmittance\" [ .5 .5 .5 ]");
  scene.replace(scene.find("0 .5 -3"), 7, "0 -.5 -3");
  const SamplingsFigure figure = samplingsOf(*sceneFrom(scene), 40000);
  const double expected = 0.25;
  for (size_t s = 0; s < SAMPLING_NAMES.size(); ++s)
    EXPECT_NEAR(double(figure.panels[s].image.pixels[0]), expected, 0.04 * expected) << SAMPLING_NAMES[s];
}

TEST(Samplings, LightIsSeenInMirrors) {
  // The camera looks into a mirror of half reflectance that shows the floor from above.
  const std::string scene =
      view(1, 1, "3 2 0  0 2 0  0 1 0", perspective(1)) +
      "LightSource \"infinite\" \"rgb L\" [ 1 1 1 ]\nMaterial \"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]\n"
      "Shape \"bilinearmesh\" \"point3 P\" [ -9 0 -9  -9 0 9  9 0 -9  9 0 9 ]\nMaterial \"conductor\" \"rgb "
      "reflectance\" [ .5 .5 .5 ]\nTranslate 0 2 0\nRotate -45 0 0 1\n"
      "Shape \"bilinearmesh\" \"point3 P\" [ 0 -.5 -.5  0 .5 -.5  0 -.5 .5  0 .5 .5 ]\n";
  const SamplingsFigure figure = samplingsOf(*sceneFrom(scene), 2000);
  const float seen = figure.panels[1].image.pixels[0];
  EXPECT_GT(seen, 0.5f * 0.5f * 0.85f); // the mirror hides a small part of the sky
  EXPECT_LT(seen, 0.5f * 0.5f);
}

TEST(Samplings, ScenesThatCannotBeDrawnAreErrorsWithTheReason) {
  const auto complaint = [](const std::string& scene) {
    try {
      samplingsOf(*sceneFrom(scene), 2);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_NE(
      complaint(floorUnderSky(1) +
                "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\nMediumInterface \"fog\" \"\"\n"
                "Material \"interface\"\nShape \"sphere\"\n")
          .find("cannot draw media"),
      std::string::npos);
  std::string dark = floorUnderSky(1);
  dark.erase(dark.find("LightSource"), dark.find("Material") - dark.find("LightSource"));
  EXPECT_NE(complaint(dark).find("needs a scene with lights"), std::string::npos);
}

/** A floor under a lamp, with a box of height `.1` that casts a shadow; the floor is oblique, so that the
 * positions on it are rounded. */
std::string obliqueFloor() {
  return view(24, 24, "0 4 .1  0 0 0  0 0 1", perspective(30)) +
         "Rotate 20 .3 .5 .8\nLightSource \"distant\" \"point3 from\" [ 0 1 1 ] \"point3 to\" [ 0 0 0 ] "
         "\"rgb L\" "
         "[ 3 3 3 ]\nMaterial \"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]\n"
         "Shape \"trianglemesh\" \"integer indices\" [ 0 1 2  0 2 3 ] \"point3 P\" [ -4 .01 -4  -4 .01 4  4 "
         ".01 4  "
         "4 .01 -4 ]\n"
         "Shape \"trianglemesh\" \"integer indices\" [ 0 1 2  0 2 3 ] \"point3 P\" [ -4 .11 .2  -4 .11 .4  4 "
         ".11 .4  "
         "4 .11 .2 ]\n";
}

TEST(Acne, IsWithoutOffsetAndLeaksAreBeyondTheBlocker) {
  const auto scene = sceneFrom(obliqueFloor());
  const std::atomic<bool> stop{false};
  const auto pictures = acnePictures(*scene, {0, 1e-4f, .11f}, 4, 1, stop);
  ASSERT_EQ(pictures.size(), 4u);
  EXPECT_GT(pictures[0].acne, 0.1);
  EXPECT_EQ(pictures[0].leaks, 0);
  EXPECT_EQ(pictures[1].acne, 0);
  EXPECT_EQ(pictures[1].leaks, 0);
  EXPECT_GT(pictures[2].leaks, 0.02); // rays start above the bar, which is .1 above the floor
  EXPECT_LT(pictures[3].offset, 0);   // the rule of the renderer
  EXPECT_EQ(pictures[1].image.pixels, pictures[3].image.pixels);
  const auto panels = acnePanels(pictures);
  EXPECT_EQ(panels.size(), 4u);
  EXPECT_NE(panels[0].name.find("acne"), std::string::npos);
}

TEST(Drawing, HasPicturesLinesAndTextsInBothForms) {
  FigureDrawing drawing;
  drawing.width = 40;
  drawing.height = 30;
  Image red(2, 2, {"R", "G", "B"});
  for (size_t i = 0; i < red.pixels.size(); i += 3) red.pixels[i] = 1;
  drawing.pictures.push_back({3, 4, red});
  drawing.pictures.push_back({-1, 29, red}); // one half is to the left, and one half below
  drawing.lines.push_back({{Vec2f(10, 10.5f), Vec2f(30, 10.5f)}, BLACK, 1});
  drawing.lines.push_back({{Vec2f(10, 20.5f), Vec2f(30, 20.5f)}, BLACK, 1, true});
  drawing.texts.push_back({0, 22, "a<b"});
  const Image sheet = rasterised(drawing);
  EXPECT_EQ(sheet.rgb(4, 5), Rgb(1, 0, 0));
  EXPECT_EQ(sheet.rgb(6, 5), Rgb(1));
  EXPECT_EQ(sheet.rgb(0, 29), Rgb(1, 0, 0));
  EXPECT_EQ(sheet.rgb(1, 29), Rgb(1));
  EXPECT_EQ(sheet.rgb(20, 10), BLACK);
  EXPECT_EQ(sheet.rgb(20, 12), Rgb(1));
  int dark = 0;
  for (int x = 0; x < sheet.width; ++x) dark += sheet.at(x, 20)[0] < 0.5f;
  EXPECT_GT(dark, 9); // of 20, in dashes of 6 with gaps of 4
  EXPECT_LT(dark, 15);
  const std::string svg = svgText(drawing);
  EXPECT_NE(svg.find("width=\"40\" height=\"30\""), std::string::npos);
  EXPECT_NE(svg.find("data:image/png;base64,iVBORw0KGgo"), std::string::npos);
  EXPECT_NE(svg.find("points=\"10.00,10.50 30.00,10.50 \""), std::string::npos);
  EXPECT_NE(svg.find("stroke-dasharray"), std::string::npos);
  EXPECT_NE(svg.find(">a&lt;b</text>"), std::string::npos);
}

TEST(Plot, PutsPointsWhereTheirLogarithmsAre) {
  FigurePlot plot{"", "x", "y", {{"curve", Rgb(1, 0, 0), {{1, 1}, {10, .1}, {100, .01}, {1000, 0}}}}, -0.5};
  const std::vector<FigurePanel> panels = {{Image(8, 8, {"R", "G", "B"}), "panel"}};
  const FigureDrawing drawing = figureSheet("title", "subtitle", panels, &plot);
  std::vector<Vec2f> curve, slope;
  for (const FigureDrawing::Line& line : drawing.lines) {
    if (line.colour == Rgb(1, 0, 0) && line.points.size() > 2) curve = line.points;
    if (line.dashed && slope.empty()) slope = line.points;
  }
  ASSERT_EQ(curve.size(), 3u); // a zero has no logarithm
  EXPECT_NEAR(curve[1].x - curve[0].x, curve[2].x - curve[1].x, 0.01f);
  EXPECT_NEAR(curve[1].y - curve[0].y, curve[2].y - curve[1].y, 0.01f);
  EXPECT_GT(curve[1].y, curve[0].y); // downwards
  ASSERT_EQ(slope.size(), 2u);
  // Both start at the same point; the curve decreases by 2 decades, the slope by 1.
  EXPECT_NEAR((slope[1].y - slope[0].y) * 2, curve[2].y - curve[0].y, 0.1f);
  EXPECT_NEAR(slope[1].x, curve[2].x, 0.1f);
  for (const FigureDrawing::Text& t : drawing.texts) {
    EXPECT_GE(t.x, 0);
    EXPECT_LE(t.x + 6 * t.size * int(t.text.size()), drawing.width) << t.text;
    EXPECT_LT(t.y, drawing.height) << t.text;
  }
}

TEST(Plot, KeepsSlopesOfBothSignsWithinTheAxes) {
  for (const double slope : {-3.0, 3.0}) {
    // Two decades of x, and one of y above and below the first point.
    const FigurePlot plot{"", "x", "y", {{"curve", Rgb(1, 0, 0), {{1, 1}, {10, 10}, {100, .1}}}}, slope};
    const std::vector<FigurePanel> panels = {{Image(8, 8, {"R", "G", "B"}), "panel"}};
    std::vector<Vec2f> curve, dashed;
    for (const FigureDrawing::Line& line : figureSheet("title", "subtitle", panels, &plot).lines) {
      if (line.colour == Rgb(1, 0, 0) && line.points.size() > 2) curve = line.points;
      if (line.dashed && dashed.empty()) dashed = line.points;
    }
    ASSERT_EQ(dashed.size(), 2u);
    EXPECT_EQ(dashed[0], curve[0]);
    EXPECT_NEAR(dashed[1].y, (slope < 0 ? curve[2] : curve[1]).y, 0.1f)
        << slope; // clipped at the edge of the axes
    EXPECT_NEAR(dashed[1].x - dashed[0].x, (curve[1].x - curve[0].x) / 3, 0.1f) << slope;
  }
}

} // namespace
} // namespace recurse
