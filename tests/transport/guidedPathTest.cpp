/** @file
 * Guided paths: the mean is the same with less noise, and the guide depends on the pass alone.
 */
#include <gtest/gtest.h>

#include "guidedScenes.h"
#include "transport/learning/guideTraining.h"
#include "transport/learning/lightLearning.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

constexpr const char* GUIDED = "\"bool guided\" true";

void expectMeanAndLessNoise(const std::string& text) {
  const auto scene = sceneFrom(text);
  const PathClasses classes;
  const int spp = samples(256);
  const auto plain = integratorFrom("path", ""), guided = integratorFrom("path", GUIDED);
  const Rendered a = renderScene(*scene, *plain, classes, spp, 1),
                 b = renderScene(*scene, *guided, classes, spp, 2);
  EXPECT_EQ(b.unsound(), "");
  EXPECT_NEAR(a.mean(), b.mean(), 4 * std::hypot(a.standardError(), b.standardError()));
  if (spp < 256) return; // too few samples for the guide to learn
  EXPECT_LT(b.standardError(), 0.85 * a.standardError());
}

} // namespace

TEST(GuidedPath, HasTheMeanOfPlainPathsAndLessNoise) { expectMeanAndLessNoise(slitRoom()); }

TEST(GuidedPath, InFogHasTheMeanOfPlainPathsAndLessNoise) {
  // Light enters the fog, which scatters it forwards, from one side.
  std::string room = slitRoom();
  room.insert(room.find("Material"), R"(
AttributeBegin
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [ .05 .02 .1 ] "rgb sigma_s" [ 1 1.2 .8 ] "float g" .3
MediumInterface "fog" ""
Material "interface"
Shape "box" "point3 p1" [ -1.5 -.9 -.9 ] "point3 p2" [ .95 .9 .9 ]
AttributeEnd
)");
  expectMeanAndLessNoise(room);
}

TEST(GuidedPath, ErrorsFallAsTheNumberOfSamplesWithoutAPlateau) {
  // Every pixel sees nearly the same point of the floor, whose radiance is known: a bias would keep the error
  // from falling.
  constexpr double HOLE = 0.3;
  const double factor = holeFormFactor(HOLE), radiance = 0.5 * factor * HOLE_RADIANCE;
  const auto scene = sceneFrom(floorBelowHole(HOLE, 16));
  const PathClasses classes;
  const auto guided = integratorFrom("path", GUIDED);
  // Relative variance of a single sample, from the squared error of pixels.
  const auto variance = [&](int spp) {
    const Rendered out = renderScene(*scene, *guided, classes, spp, 4);
    double squares = 0;
    for (size_t i = 0; i < out.pixels(); ++i) squares += square(out.luminanceAt(i) / radiance - 1);
    return spp * squares / double(out.pixels());
  };
  const double cosine = 1 / factor - 1, early = variance(16), late = variance(samples(1024));
  EXPECT_LT(early, 0.6 * cosine);
  EXPECT_LT(late, 1.2 * early);
  EXPECT_LT(variance(128), 1.2 * early);
}

TEST(GuidedPath, StatisticsAreOfTheLatestPass) {
  const auto scene = sceneFrom(slitRoom());
  const PathClasses classes;
  const auto guided = integratorFrom("path", GUIDED);
  const auto of = [&](int spp) { return renderScene(*scene, *guided, classes, spp, 1).statistics.guide; };
  EXPECT_FALSE(of(1)) << "the first sample has no guide";
  const auto early = of(2), late = of(16);
  ASSERT_TRUE(early && late);
  EXPECT_GT(late->cellsOn, 0u);
  EXPECT_LE(late->cellsOn, late->cells);
  EXPECT_GT(late->gain, early->gain);
  EXPECT_GT(late->records, early->records);
  EXPECT_GT(late->cells, early->cells);
  const auto plain = integratorFrom("path", "");
  EXPECT_FALSE(renderScene(*scene, *plain, classes, 2, 1).statistics.guide);
}

TEST(GuidedPath, GainIsTheRatioOfSecondMoments) {
  // Every pixel sees nearly the same point of the floor. Stratified samples would have less variance.
  const auto scene = sceneFrom("Sampler \"independent\"\n" + floorBelowHole(0.3, 32));
  const auto plain = integratorFrom("path", ""), guided = integratorFrom("path", GUIDED);
  constexpr int SPP = 256; // of which the first few are not guided
  const auto secondMoment = [&](const Rendered& out) {
    double squares = 0;
    for (size_t i = 0; i < out.pixels(); ++i) squares += square(out.luminanceAt(i) - out.mean());
    return square(out.mean()) + SPP * squares / double(out.pixels());
  };
  const Rendered a = renderScene(*scene, *plain, PathClasses(), SPP, 4),
                 b = renderScene(*scene, *guided, PathClasses(), SPP, 4);
  ASSERT_TRUE(b.statistics.guide);
  EXPECT_GT(b.statistics.guide->gain, 2);
  EXPECT_NEAR(b.statistics.guide->gain / (secondMoment(a) / secondMoment(b)), 1, 0.15);
}

TEST(GuidedPath, AGuideThatDoesNotRepayItsTimeIsNotFollowed) {
  // Shadow rays find most light of a lamp in a grey box.
  const auto scene = sceneFrom(view(16, 16, "0 0 -.9  0 0 1  0 1 0", perspective(90)) + R"(
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 9 9 9 ]
Translate 0 .9 0
Rotate 90 1 0 0
Shape "disk" "float radius" .3
AttributeEnd
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
Shape "box" "point3 p1" [ -1 -1 -1 ] "point3 p2" [ 1 1 1 ]
)");
  const PathClasses classes;
  const auto plain = integratorFrom("path", ""), guided = integratorFrom("path", GUIDED);
  const auto records = [&](int spp) {
    const Rendered a = renderScene(*scene, *plain, classes, spp, 1),
                   b = renderScene(*scene, *guided, classes, spp, 1);
    for (size_t i = 0; i < a.pixels(); ++i) EXPECT_EQ(a.luminanceAt(i), b.luminanceAt(i)) << spp << " " << i;
    EXPECT_EQ(b.statistics.guide->cellsOn, 0u);
    EXPECT_NEAR(b.statistics.guide->gain, 1, 0.3);
    return b.statistics.guide->records;
  };
  EXPECT_EQ(records(8), records(32)) << "training ends after three stages";
}

TEST(GuidedPath, APassAloneHasTheGuideOfTheSequence) {
  const auto scene = sceneFrom(slitRoom());
  LightSampler lights;
  learnLights(*scene, lights);
  TransportCounts counts;
  const uint64_t learning = counts.rays;
  GuideTraining sequence({}), alone({});
  Pass pass;
  pass.seed = 5;
  for (pass.index = 0; pass.index <= 4; ++pass.index) {
    sequence.prepare(*scene, lights, pass, {}, counts);
    if (pass.index == 0) {
      EXPECT_EQ(counts.rays, learning) << "the first picture waits for nothing";
    }
  }
  pass.index = 4;
  alone.prepare(*scene, lights, pass, {}, counts);
  ASSERT_TRUE(sequence.guide() && alone.guide());
  EXPECT_EQ(sequence.guide()->cellCount(), alone.guide()->cellCount());
  const Vec3f direction = glm::normalize(Vec3f(0.7f, 0.3f, 0.6f));
  int found = 0;
  for (int i = 0; i < 100; ++i) {
    const Vec3f position = scene->bounds().center + Vec3f(0.03f * float(i - 50), -1, 0.01f * float(i % 7));
    const GuideCell *one = sequence.guide()->find(position, {0, 1, 0}),
                    *other = alone.guide()->find(position, {0, 1, 0});
    ASSERT_EQ(one == nullptr, other == nullptr);
    if (!one) continue;
    ++found;
    EXPECT_EQ(one->pdf(direction), other->pdf(direction));
  }
  EXPECT_GT(found, 0);
}

TEST(GuidedPath, StagesOfAMovingSceneHaveTimesOfTheirOwn) {
  const auto scene = sceneFrom(slitRoom() + R"(
ActiveTransform EndTime
Translate 0 .3 0
ActiveTransform All
Shape "sphere" "float radius" .2
)");
  ASSERT_TRUE(scene->moves());
  LightSampler lights;
  TransportCounts counts;
  std::array<GuideTraining, 2> trainings{GuideTraining({}), GuideTraining({})};
  for (size_t i = 0; i < 2; ++i) { // a render that is continued trains all stages in a later pass
    Pass pass{5, 3, PassSchedule::DOUBLING, 0.4f * float(i + 1)};
    trainings[i].prepare(*scene, lights, pass, {}, counts);
  }
  EXPECT_EQ(trainings[0].statistics(), trainings[1].statistics());
}

TEST(GuidedPath, ASecondRenderByTheSameIntegratorForgetsTheFirst) {
  const auto scene = sceneFrom(slitRoom());
  const PathClasses classes;
  for (const char* name : {"path", "bdpt"}) {
    const auto guided = integratorFrom(name, GUIDED);
    const Rendered first = renderScene(*scene, *guided, classes, 16, 1),
                   second = renderScene(*scene, *guided, classes, 16, 1);
    ASSERT_EQ(first.pixels(), second.pixels());
    for (size_t i = 0; i < first.pixels(); ++i)
      EXPECT_EQ(first.luminanceAt(i), second.luminanceAt(i)) << name << " " << i;
  }
}

TEST(GuidedPath, InAFurnaceEveryPixelIsTheRadianceOfEverything) {
  // A closed shell that emits 1 and reflects a half has the radiance 2 everywhere.
  const auto scene = sceneFrom(view(8, 8, "0 0 0  1 0 0  0 1 0", perspective(90)) + R"(
AreaLightSource "diffuse" "rgb L" [ 1 1 1 ] "bool twosided" true
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
Shape "sphere" "float radius" 1
)");
  const PathClasses classes;
  for (const char* name : {"path", "bdpt"}) {
    const auto guided = integratorFrom(name, GUIDED);
    const Rendered out = renderScene(*scene, *guided, classes, samples(256), 3);
    EXPECT_NEAR(out.mean(), 2, 4 * out.standardError()) << name;
  }
}
