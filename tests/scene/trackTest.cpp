/** @file
 * Tracks, and `$name` instead of numbers.
 */
#include "scene/directives/track.h"
#include "sceneTesting.h"

using namespace recurse;

namespace {

SceneDescription frameOf(const std::string& text, double frame) {
  TemporaryDirectory folder;
  folder.write("s.pbrt", text);
  Diagnostics diagnostics;
  SceneDescription scene = loadScene(folder.path("s.pbrt"), diagnostics, frame);
  EXPECT_TRUE(diagnostics.all().empty()) << diagnostics.format();
  return scene;
}

} // namespace

TEST(Track, StepAndStraight) {
  using enum Track::Interpolation;
  const Track step({2, 4, 8}, {1, 10, 3, 30, 5, 50}, STEP, false);
  EXPECT_EQ(step.at(0), (std::vector<double>{1, 10}));
  EXPECT_EQ(step.at(3.9), (std::vector<double>{1, 10}));
  EXPECT_EQ(step.at(4), (std::vector<double>{3, 30}));
  EXPECT_EQ(step.at(100), (std::vector<double>{5, 50}));
  const Track straight({2, 4, 8}, {1, 10, 3, 30, 5, 50}, LINEAR, false);
  EXPECT_EQ(straight.at(5), (std::vector<double>{3.5, 35}));
  EXPECT_EQ(straight.at(8), (std::vector<double>{5, 50}));
  EXPECT_EQ(Track({3}, {7}, SMOOTH, true).at(12), (std::vector<double>{7}));
}

TEST(Track, SmoothGoesThroughKeyframesAndKeepsStraightLines) {
  const Track line({0, 1, 5, 7}, {1, 3, 11, 15}, Track::Interpolation::SMOOTH, false);
  for (const double t : {0.0, 0.3, 1.0, 2.5, 5.0, 6.9, 7.0}) EXPECT_NEAR(line.at(t)[0], 1 + 2 * t, 1e-12);
  const Track wave({0, 1, 2, 3, 4}, {0, 1, 0, -1, 0}, Track::Interpolation::SMOOTH, true);
  EXPECT_NEAR(
      wave.at(0.5)[0], 0.625,
      1e-12); // slopes 1 and 0 at its ends The slope is continuous at keyframes, and where the track repeats.
  for (const double t : {1.0, 2.0, 4.0, 8.0}) {
    const double h = 1e-6, before = wave.at(t)[0] - wave.at(t - h)[0],
                 after = wave.at(t + h)[0] - wave.at(t)[0];
    EXPECT_NEAR(before / h, after / h, 1e-4) << t;
  }
}

TEST(Track, Repeats) {
  const Track ramp({10, 14}, {0, 4}, Track::Interpolation::LINEAR, true);
  for (const int n : {-3, 0, 5}) EXPECT_NEAR(ramp.at(11 + 4 * n)[0], 1, 1e-12);
}

TEST(Track, AFrameIsTheSceneWithItsNumbersWrittenOut) {
  const std::string text = R"(
    Animate "eye" "float times" [ 0 10 ] "float values" [ 0 0 5  1 2 6 ]
    Animate "r" "float times" [ 0 3 ] "float values" [ .1 .2 ]
    LookAt $eye 0 0 0 0 1 0
    WorldBegin
    Translate $r 0 [EYE]
    Shape "sphere" "float radius" $r
    Shape "trianglemesh" "point3 P" [ 0 0 0 $eye $r $r $r ] "integer indices" [ 0 1 2 ])";
  std::string withTrack = text;
  withTrack.replace(withTrack.find("[EYE]"), 5, "0");
  const SceneDescription s = frameOf(withTrack, 1);
  char r[40];
  std::snprintf(r, sizeof r, "%.17g", (1 - 1.0 / 3) * .1 + 1.0 / 3 * .2);
  const std::string e = "0.10000000000000001 0.20000000000000001 5.0999999999999996";
  const SceneDescription w = frameOf("LookAt " + e + " 0 0 0 0 1 0 WorldBegin Translate " + r +
                                         " 0 0 Shape \"sphere\" \"float radius\" " + r +
                                         " Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 " + e + " " + r + " " +
                                         r + " " + r + " ] \"integer indices\" [ 0 1 2 ]",
                                     0);
  EXPECT_EQ(s.worldFromCamera, w.worldFromCamera);
  ASSERT_EQ(s.shapes.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(s.shapes[i].worldFromObject, w.shapes[i].worldFromObject);
    EXPECT_EQ(s.shapes[i].shape.parameters[0].numbers, w.shapes[i].shape.parameters[0].numbers);
  }
  ASSERT_EQ(s.tracks.size(), 2u);
  EXPECT_EQ(s.tracks[0].lastTime, 10);
}

TEST(Track, StandsInStringsAsAWholeNumber) {
  const std::string track = "Animate \"n\" \"float times\" [ 0 10 ] \"float values\" [ 0 20 ] "
                            "Animate \"my.n\" \"float times\" [ 0 ] \"float values\" [ -3 ] WorldBegin ";
  const auto nameOf = [&](const std::string& text, double frame) {
    const SceneDescription s =
        frameOf(track +
                    "Attribute \"shape\" \"float radius\" $my.n Shape \"plymesh\" \"string filename\" \"$n\" "
                    "Shape \"plymesh\" \"string filename\" \"" +
                    text + "\"",
                frame);
    return s.shapes.back().shape.parameters.at(0).strings.at(0);
  };
  EXPECT_EQ(nameOf("cloth$n.ply", 3), "cloth6.ply");
  EXPECT_EQ(nameOf("cloth$n%04d.ply", 3), "cloth0006.ply");
  EXPECT_EQ(nameOf("${n}a$n-$n_b/${my.n}%03d", 3), "6a6-$n_b/-03");
  EXPECT_EQ(nameOf("$n", 1.3), "3"); // 2.6
  EXPECT_EQ(nameOf("$n%d$n%.ply", 5), "10%d10%.ply");
  EXPECT_EQ(nameOf("$m ${n $ 5$", 5), "$m ${n $ 5$");
}

TEST(Track, StringsWithoutTracksStayAsTheyAre) {
  const SceneDescription s = parseGood("WorldBegin Shape \"plymesh\" \"string filename\" \"a$n%04d.ply\"");
  EXPECT_EQ(s.shapes.back().shape.parameters.at(0).strings.at(0), "a$n%04d.ply");
}

TEST(Track, ErrorsPointAtItsUse) {
  const std::string tracks = "Animate \"a\" \"float times\" [ 0 ] \"float values\" [ 1 2 ]\nWorldBegin\n";
  EXPECT_CONTAINS(messages(tracks + "Shape \"sphere\" \"float radius\" $a"), "test.pbrt:3:31: error:");
  EXPECT_CONTAINS(messages(tracks + "Translate $a $a"), "test.pbrt:3:14: error:");
  EXPECT_CONTAINS(messages(tracks + "Shape \"sphere\" \"string x\" \"is$a\""),
                  "test.pbrt:3:30: error: track $a has 2 numbers");
  EXPECT_CONTAINS(messages("Animate \"n\" \"float times\" [ 0 ] \"float values\" [ 1 ]\nWorldBegin\n"
                           "Shape \"sphere\" \"string x\" \"is$n%4d\""),
                  "test.pbrt:3:32: error: the width of the number $n cannot be read");
}

TEST(Track, SaysWhatIsWrong) {
  const std::string good = "\"float times\" [ 0 1 ] \"float values\" [ 1 2 ] ";
  const auto used = [](const std::string& animate) {
    return messages(animate + " WorldBegin Translate $a 0 0");
  };
  EXPECT_EQ(used("Animate \"a\" " + good), "");
  EXPECT_CONTAINS(used("Animate \"b\" " + good), "there is no track '$a' yet");
  EXPECT_CONTAINS(used("Animate \"b\" " + good), "no parameter uses the track \"b\"");
  EXPECT_CONTAINS(messages("Animate \"ball\" " + good + "WorldBegin Translate $bal 0 0"), "$ball");
  EXPECT_CONTAINS(used("Animate \"a\" " + good + "Animate \"a\" " + good), "already defined");
  EXPECT_CONTAINS(used("Animate \"a b\" " + good), "a track cannot be called \"a b\"");
  EXPECT_CONTAINS(used("Animate \"a\" \"float times\" [ 1 0 ] \"float values\" [ 1 2 ]"), "do not increase");
  EXPECT_CONTAINS(used("Animate \"a\" \"float times\" [ 0 1 ] \"float values\" [ 1 2 3 ]"),
                  "3 values for 2 times");
  EXPECT_CONTAINS(used("Animate \"a\" \"float times\" [ ] \"float values\" [ ]"), "0 values");
  EXPECT_CONTAINS(used("Animate \"a\" \"float time\" [ 0 1 ] \"float values\" [ 1 2 ]"), "times");
  EXPECT_CONTAINS(used("Animate \"a\" " + good + "\"string interpolation\" \"cubic\""), "smooth");
  // A track of two numbers where the parameter has one.
  EXPECT_CONTAINS(messages("Animate \"a\" \"float times\" [ 0 ] \"float values\" [ 1 2 ] WorldBegin "
                           "Shape \"sphere\" \"float radius\" $a"),
                  "need brackets");
}
