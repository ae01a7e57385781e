/** @file
 * Trials of estimators, and the choices of auto.
 */
#include "rendering.h"

#include <random>

#include "integrators/auto/estimatorTrial.h"
#include "integrators/photonmap/photonPass.h"
#include "transport/learning/lightLearning.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Large enough for a trial. */
constexpr int SIZE = 96;

/** A ball with a nearly smooth coat on a floor of the same material, under an open sky. */
std::string coats() {
  return view(SIZE, "0 1.5 4  0 .4 0  0 1 0", 40) + "LightSource \"infinite\" \"rgb L\" [1 1 1]\n"
                                                    "Material \"coateddiffuse\" \"float roughness\" .001\n"
                                                    "Shape \"sphere\" \"float radius\" .6\n"
                                                    "Translate 0 -.6 0\n"
                                                    "Shape \"disk\" \"float radius\" 5\n";
}

/** A glass ball in a box with a small lamp. */
std::string glassBall(const std::string& lamp) {
  return view(SIZE, "0 0 3.9  0 0 0  0 1 0", 39.3) + R"(
Material "diffuse" "rgb reflectance" [ .7 .7 .7 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 1 -1  -1 1 1  1 1 1  1 1 -1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  -1 1 -1  1 1 -1  1 -1 -1 ]
)" + lamp +
         R"(
AttributeBegin
Material "dielectric"
Translate 0 -.5 0
Shape "sphere" "float radius" .4
AttributeEnd
)";
}

const std::string SMALL_LAMP = R"(
AttributeBegin
Translate 0 .95 0
AreaLightSource "diffuse" "rgb L" [ 900 900 900 ]
Shape "sphere" "float radius" .02
AttributeEnd
)";

/** The note of auto about its choice. */
std::string choiceOf(const Rendered& r) {
  for (const std::string& note : r.statistics.notes)
    if (note.starts_with("auto ")) return note;
  ADD_FAILURE() << "auto says nothing";
  return {};
}

bool isLeftToPaths(const Rendered& r) { return choiceOf(r).starts_with("auto chose path"); }

} // namespace

TEST(EstimatorTrial, FiguresAreVariancesByScale) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  constexpr float MEAN = 2, PIXEL = 0.3f, SHARED = 0.1f;
  constexpr int BLOCK_PIXELS = EstimatorTrial::BLOCK * EstimatorTrial::BLOCK;
  EstimatorTrial::Rounds noisy, exact;
  for (int k = 0; k < 2; ++k) {
    float shared = 0;
    for (int i = 0; i < EstimatorTrial::PIXELS; ++i) {
      if (i % BLOCK_PIXELS == 0) shared = SHARED * normal(random);
      noisy[size_t(k)].luminance.push_back(MEAN + shared + PIXEL * normal(random));
      exact[size_t(k)].luminance.push_back(MEAN);
    }
    noisy[size_t(k)].counts.rays = exact[size_t(k)].counts.rays = 3 * EstimatorTrial::PIXELS;
  }
  const EstimatorTrial::Figures f = EstimatorTrial::figures(noisy, exact);
  // Expected value, up to a hundredth of the mean square in the denominator.
  const double ofPixels = (PIXEL * PIXEL + SHARED * SHARED) / (1.01 * MEAN * MEAN);
  const double ofBlocks = (PIXEL * PIXEL / BLOCK_PIXELS + SHARED * SHARED) / (1.01 * MEAN * MEAN);
  EXPECT_NEAR(f.ofPixels, ofPixels, 0.1 * ofPixels);
  EXPECT_NEAR(f.ofBlocks, ofBlocks, 0.4 * ofBlocks); // the estimate has 144 blocks
  EXPECT_DOUBLE_EQ(f.work, 3);
  EXPECT_EQ(EstimatorTrial::figures(exact, noisy).ofPixels, 0);

  EstimatorTrial::Figures slower = f;
  slower.work *= 2;
  slower.add(0);
  EXPECT_DOUBLE_EQ(slower.errorOver(f), 2);
}

TEST(EstimatorTrial, WhatBothFindIsBrightForBoth) {
  EstimatorTrial::Rounds edge, spark, other;
  for (size_t k = 0; k < 2; ++k)
    for (EstimatorTrial::Rounds* rounds : {&edge, &spark, &other}) {
      (*rounds)[k].luminance.assign(EstimatorTrial::PIXELS, 1);
      (*rounds)[k].counts.rays = EstimatorTrial::PIXELS;
    }
  constexpr float BRIGHT = 1000;
  edge[0].luminance[5] = spark[0].luminance[5] = other[0].luminance[5] = BRIGHT;
  const EstimatorTrial::Figures known = EstimatorTrial::figures(edge, other);
  other[0].luminance[5] = 1;
  const EstimatorTrial::Figures rare = EstimatorTrial::figures(spark, other);
  EXPECT_NEAR(known.ofPixels * EstimatorTrial::PIXELS, 2, 0.02);
  EXPECT_GT(rare.ofPixels, 100 * known.ofPixels);
}

TEST(EstimatorTrial, LampsThemselvesAreLeftOut) {
  // Lamp visible directly, in a mirror, through glass, and through a haze that only absorbs; no other light
  // is visible.
  const std::string lamp = view(SIZE, "0 0 3  0 0 0  0 1 0", 40) + R"(
Material "conductor" "rgb reflectance" [ .5 .5 .5 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -.5 -2  2 -.5 -2  2 -.5 2  -2 -.5 2 ]
AttributeBegin
Material "dielectric"
Translate .5 0 0
Shape "sphere" "float radius" .2
AttributeEnd
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Translate 0 .1 -.5
AreaLightSource "diffuse" "rgb L" [ 900 900 900 ]
Shape "sphere" "float radius" .3
)";
  const std::string haze = "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [0 0 0]\n"
                           "MediumInterface \"\" \"m\"\n" +
                           lamp;
  for (const std::string& text : {lamp, haze})
    for (const char* name : {"path", "photonmap"}) {
      const auto scene = sceneFrom(text);
      const auto integrator = integratorFrom(name, "");
      const PathClasses classes;
      integrator->prepare(*scene, classes);
      integrator->forward(*scene, classes, {1, 0, PassSchedule::PER_SAMPLE, 0}, {});
      const TrialSamples samples = EstimatorTrial(*scene, classes, 1, 0).take(*integrator, 0);
      for (const float luminance : samples.luminance) ASSERT_LT(luminance, 1e-3f) << name;
      EXPECT_GT(renderScene(*scene, name, "", 1).mean(), 1) << name;
    }
}

TEST(EstimatorTrial, CoatsUnderTheSkyAreLeftToPaths) {
  const auto scene = sceneFrom(coats());
  const Rendered paths = renderScene(*scene, "path", "", 2), chosen = renderScene(*scene, "auto", "", 2);
  EXPECT_TRUE(isLeftToPaths(chosen));
  for (size_t i = 0; i < paths.pixels(); ++i) ASSERT_EQ(chosen.value(i), paths.value(i)) << i;
}

TEST(EstimatorTrial, CausticsAreLeftToPhotonsWherePathsBringTheRest) {
  const auto scene = sceneFrom(coats() + R"(
Material "dielectric"
AttributeBegin
Translate 1 .4 0
Shape "sphere" "float radius" .4
AttributeEnd
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Translate 2.5 4 0
AreaLightSource "diffuse" "rgb L" [ 50000 50000 50000 ]
Shape "sphere" "float radius" .05
)");
  const Rendered chosen = renderScene(*scene, "auto", "", 2),
                 asked = renderScene(*scene, "photonmap", "\"bool causticsonly\" true", 2);
  EXPECT_TRUE(isLeftToPaths(chosen));
  for (size_t i = 0; i < chosen.pixels(); ++i) ASSERT_EQ(chosen.value(i), asked.value(i)) << i;
}

TEST(EstimatorTrial, CausticsOfPointsInMediaStayWithPhotons) {
  // No path finds the sun's light behind glass, and in combination with path tracing no photons are stored in
  // the haze.
  const std::string haze =
      "LightSource \"distant\" \"point3 from\" [0 1 1] \"rgb L\" [.1 .1 .1]\n"
      "MakeNamedMedium \"haze\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0 0 0] "
      "\"rgb sigma_s\" [.05 .05 .05]\nMaterial \"interface\"\nMediumInterface \"haze\" \"\"\n"
      "Translate 0 1 0\nShape \"sphere\" \"float radius\" .3\n";
  const std::string glass = "MediumInterface \"\" \"haze\"\nMaterial \"dielectric\"\n"
                            "Shape \"sphere\" \"float radius\" .1\n";
  EXPECT_TRUE(isLeftToPaths(renderText(coats() + haze, "auto", "", 1)));
  EXPECT_FALSE(isLeftToPaths(renderText(coats() + haze + glass, "auto", "", 1)));
}

TEST(EstimatorTrial, MediaHideNoCaustics) {
  // A thin medium inside of the ball, which only absorbs.
  const std::string lamp = SMALL_LAMP + R"(
MakeNamedMedium "faint" "string type" "homogeneous" "rgb sigma_a" [ .01 .02 .03 ] "rgb sigma_s" [ 0 0 0 ]
MediumInterface "faint" ""
)";
  const auto scene = sceneFrom(glassBall(lamp));
  PhotonPassSettings settings;
  settings.alpha = 2.0 / 3;
  PhotonPass photons(settings);
  LightSampler lights;
  learnLights(*scene, lights);
  photons.run(*scene, PathClasses(), {1, 0, PassSchedule::PER_SAMPLE, 0}, {}, lights);
  EXPECT_GT(photons.causticVarianceByRays(), 10);
}

TEST(EstimatorTrial, CausticsStayWithPhotons) {
  EXPECT_FALSE(isLeftToPaths(renderText(glassBall(SMALL_LAMP), "auto", "", 1)));
  // Path tracing does not find the caustic of a point light, whatever its own noise.
  EXPECT_FALSE(isLeftToPaths(renderText(
      glassBall("LightSource \"point\" \"rgb I\" [1 1 1] \"point3 from\" [0 .9 0]"), "auto", "", 1)));
}

TEST(EstimatorTrial, LightThatNoPathFindsIsMissed) {
  EstimatorTrial::Rounds black, grey;
  for (size_t k = 0; k < 2; ++k) {
    black[k].luminance.assign(EstimatorTrial::PIXELS, 0);
    grey[k].luminance.assign(EstimatorTrial::PIXELS, 3);
  }
  EXPECT_DOUBLE_EQ(EstimatorTrial::missedVariance(black, grey), 2 * EstimatorTrial::PIXELS * 0.64);
  EXPECT_EQ(EstimatorTrial::missedVariance(grey, black), 0);
  EXPECT_EQ(EstimatorTrial::missedVariance(grey, grey), 0);
  EXPECT_EQ(EstimatorTrial::missedVariance(black, black), 0);
  // A small lamp in a glass ball, behind a wall: its caustics are hidden, and the light that they reflect is
  // visible.
  const std::string hidden = view(SIZE, "0 0 .95  0 -1 -.2  0 1 0", 40) + R"(
Material "diffuse" "rgb reflectance" [ .7 .7 .7 ]
Shape "box" "point3 p1" [ -1 -1 -1 ] "point3 p2" [ 1 1 1 ]
Shape "box" "point3 p1" [ -1 .3 -1 ] "point3 p2" [ 1 .35 .5 ]
Translate -.5 .7 -.5
Material "dielectric"
Shape "sphere" "float radius" .1
Material "conductor" "rgb reflectance" [ .5 .5 .5 ]
AreaLightSource "diffuse" "rgb L" [ 10000 10000 10000 ]
Shape "sphere" "float radius" .002
)";
  const Rendered chosen = renderText(hidden, "auto", "", 1);
  EXPECT_FALSE(isLeftToPaths(chosen));
  EXPECT_GT(chosen.mean(), 0);
}

TEST(EstimatorTrial, FewSamplesAreNotJudged) {
  TrialSamples samples;
  samples.luminance.assign(100, 0.0f);
  EXPECT_EQ(EstimatorTrial::effectiveCount({samples, samples}), 0);
  samples.luminance[3] = 5;
  EXPECT_NEAR(EstimatorTrial::effectiveCount({samples, samples}), 2, 1e-6);
  samples.luminance.assign(100, 0.5f);
  EXPECT_NEAR(EstimatorTrial::effectiveCount({samples, samples}), 200, 1e-4);
}

TEST(EstimatorTrial, LightThroughASlitStaysWithPhotons) {
  // About ten of 18,000 paths carry all light; an estimate from the errors of the other paths would favour
  // path tracing.
  const auto scene = sceneFrom(view(SIZE, "-1.2 1.4 -1.8  .4 1 2  0 1 0", 55) + R"(
Material "diffuse" "rgb reflectance" [ .7 .7 .7 ]
Shape "box" "point3 p1" [ -2 0 -2 ] "point3 p2" [ 2 2.5 6 ]
Shape "bilinearmesh" "point3 P" [ -2 0 2  .998 0 2  -2 2.5 2  .998 2.5 2 ]
Shape "bilinearmesh" "point3 P" [ 1 0 2  2 0 2  1 2.5 2  2 2.5 2 ]
AreaLightSource "diffuse" "rgb L" [ 40 40 40 ]
Shape "bilinearmesh" "point3 P" [ 1.2 2.49 4.5  1.7 2.49 4.5  1.2 2.49 5  1.7 2.49 5 ]
)");
  for (uint64_t seed = 3; seed <= (SANITIZED ? 3 : 4); ++seed)
    EXPECT_FALSE(isLeftToPaths(renderScene(*scene, "auto", "", 1, seed))) << seed;
}
