/** @file
 * Marks of pictures with deliberate mistakes: the marks must name exactly these mistakes. Pictures and
 * reference have independent noise.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include <nlohmann/json.hpp>

#include "recurse/core/io/error.h"
#include "recurse/pathclasses/pathExpression.h"
#include "recurse/report/marking/marking.h"
#include "report/marking/alignment.h"
#include "report/markingPictures.h"
#include "report/markingScenes.h"
#include "report/noise.h"

using namespace recurse;
using namespace markingPictures;

namespace {

/** Reference of a scene, and its classes as a student would render them, with fewer samples and a different
 * seed. */
struct Exercise {
  std::string name;
  Stills reference, student;
};

std::vector<Exercise> exercisesOf(uint64_t referenceSeed, uint64_t studentSeed) {
  std::vector<Exercise> out;
  using namespace markingScenes;
  for (const auto& [name, text] : {std::pair<std::string, std::string>{"room", room()},
                                   {"outdoors", outdoors()},
                                   {"mirror", wallWithMirror()},
                                   {"corner", corner()},
                                   {"glass", glass()}})
    out.push_back({name, renderedStills(text, 128, referenceSeed), renderedStills(text, 64, studentSeed)});
  return out;
}

const std::vector<Exercise>& exercises() {
  static const std::vector<Exercise> ALL = exercisesOf(1, 2);
  return ALL;
}

/** Mistake of a student. */
struct Mistake {
  std::map<std::string, double> factors; ///< factors of wrong classes
  PictureChange change;
  double exposure = 1;
};

/** Picture after the change; new pixels at the border repeat the border. */
Image changed(const Image& image, const PictureChange& change) {
  Image out = image;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const int fx = std::clamp(x - change.shiftX, 0, out.width - 1),
                fy = std::clamp(y - change.shiftY, 0, out.height - 1);
      for (size_t c = 0; c < 3; ++c)
        out.at(change.isFlippedHorizontally ? out.width - 1 - x : x,
               change.isFlippedVertically ? out.height - 1 - y : y)[c] =
            encoded(image.at(fx, fy)[c], change.encoding);
    }
  return out;
}

Image pictureOf(const Exercise& exercise, const Mistake& mistake, unsigned seed) {
  const Image light = sumOfLayers(exercise.student, [&](const std::string& name, int, int) {
    const auto found = mistake.factors.find(name);
    return mistake.exposure * (found == mistake.factors.end() ? 1 : found->second);
  });
  return changed(grained(light, 0.1, seed), mistake.change);
}

ClassState stateOf(double factor) {
  return factor == 1   ? ClassState::RIGHT
         : factor == 0 ? ClassState::MISSING
         : factor == 2 ? ClassState::DOUBLED
                       : ClassState::SCALED;
}

/** Expects that the marks name this mistake alone. */
void expectFound(const Marking& marking, const Mistake& mistake) {
  EXPECT_EQ(marking.change, mistake.change);
  EXPECT_GT(marking.changeCertainty, 0.9);
  EXPECT_NEAR(marking.exposure, mistake.exposure, 0.06 * mistake.exposure);
  EXPECT_EQ(marking.exposureError > 0, mistake.exposure != 1);
  EXPECT_TRUE(marking.confusions.empty());
  EXPECT_FALSE(marking.isUnexplained());
  for (const ClassMark& mark : marking.classes) {
    const auto made = mistake.factors.find(mark.name);
    if (made == mistake.factors.end()) {
      EXPECT_TRUE(mark.state == ClassState::RIGHT || mark.state == ClassState::UNKNOWN) << mark.name;
      continue;
    }
    EXPECT_EQ(mark.state, stateOf(made->second)) << mark.name;
    EXPECT_GT(mark.certainty, 0.9) << mark.name;
    EXPECT_NEAR(mark.factor, made->second, 0.1 + 3 * mark.standardError) << mark.name;
    EXPECT_TRUE(mark.visibleFraction == 0 || mark.stateFraction > 0.8)
        << mark.name << " " << mark.stateFraction;
  }
}

constexpr double PI = std::numbers::pi;

PictureChange encodedAs(ValueEncoding encoding) { return {.encoding = encoding}; }
PictureChange flipped(bool horizontally, bool vertically) {
  return {.isFlippedHorizontally = horizontally, .isFlippedVertically = vertically};
}
PictureChange shifted(int x, int y) { return {.shiftX = x, .shiftY = y}; }

/** Six mistakes for each scene, which are visible in it. */
std::map<std::string, std::vector<Mistake>> mistakes() {
  return {{"room",
           {{{{"direct-diffuse", 0}}, {}},
            {{{"interreflection-1", 2}}, {}},
            {{{"interreflection-more", 0}}, {}},
            {{{"direct-diffuse", 1 / PI}}, {}},
            {{{"interreflection-2", 0}}, flipped(true, false)},
            {{}, {}, 0.5}}},
          {"outdoors",
           {{{{"direct-specular", 0}}, {}},
            {{{"direct-diffuse", 2}}, {}},
            {{{"emitted", 0}}, {}},
            {{}, encodedAs(ValueEncoding::SRGB)},
            {{}, flipped(false, true)},
            {{{"caustic", 0}}, shifted(4, 3)}}},
          {"mirror",
           {{{{"specular-of-diffuse", 0}}, {}},
            {{{"interreflection-1", 0}}, {}},
            {{{"direct-diffuse", 2}, {"interreflection-1", 2}}, {}},
            {{}, encodedAs(ValueEncoding::DECODED)},
            {{}, shifted(0, -2)},
            {{{"specular-of-diffuse", 2}}, {}, PI}}},
          {"corner",
           {{{{"direct-diffuse", 0}}, {}},
            {{{"interreflection-1", 2}}, {}},
            {{{"emitted", 1 / PI}}, {}},
            {{{"direct-specular", 0}}, flipped(true, true)},
            {{{"interreflection-1", 0}}, encodedAs(ValueEncoding::SRGB)},
            {{}, shifted(-6, 1)}}},
          {"glass",
           {{{{"caustic", 0}}, {}},
            {{{"direct-diffuse", 0.5}}, {}},
            {{{"specular-of-diffuse", 0}}, {}},
            {{{"caustic", 0}}, flipped(true, false)},
            {{{"interreflection-1", 0}}, {}},
            {{}, {}, 1.3}}}};
}

std::string errorOf(const Image& picture, const Stills& reference) {
  try {
    markExercise(picture, reference);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

} // namespace

TEST(Marking, ThirtyMistakesAreFound) {
  int count = 0;
  const auto all = mistakes();
  for (const Exercise& exercise : exercises())
    for (const Mistake& mistake : all.at(exercise.name)) {
      SCOPED_TRACE(exercise.name + ", mistake " + std::to_string(count));
      const Marking marking =
          markExercise(pictureOf(exercise, mistake, unsigned(++count)), exercise.reference);
      SCOPED_TRACE(markingText(marking));
      expectFound(marking, mistake);
      EXPECT_FALSE(marking.isRight());
      EXPECT_FALSE(markingStatements(marking).empty());
    }
  EXPECT_EQ(count, 30);
}

TEST(Marking, ExamplePathIsAtSurfacesIfThereIsOne) {
  const auto adviceOn = [](const std::string& expression) {
    ClassMark mark;
    mark.name = "class";
    mark.expression = expression;
    mark.state = ClassState::MISSING;
    Marking marking;
    marking.classes = {mark};
    return markingStatements(marking).at(0).advice;
  };
  EXPECT_NE(adviceOn("all - (LS*E|LDE|LD+S+E)").find("lamp, mirror or glass, diffuse or glossy surface, eye"),
            std::string::npos);
  EXPECT_NE(adviceOn("LVE").find("lamp, medium, eye"), std::string::npos);
}

TEST(Marking, MaximumDepthIsNamedIfAClassHasLongerPaths) {
  const auto adviceOn = [](const std::string& expression, double factor) {
    ClassMark mark;
    mark.name = "class";
    mark.expression = expression;
    mark.state = ClassState::SCALED;
    mark.factor = factor;
    Marking marking;
    marking.classes = {mark};
    return markingStatements(marking).at(0).advice;
  };
  EXPECT_NE(adviceOn("LD+S+E", 0.6).find("maximum depth"), std::string::npos);
  EXPECT_EQ(adviceOn("LD+S+E", 1.6).find("maximum depth"), std::string::npos);
  EXPECT_EQ(adviceOn("L(S|D)DE", 0.6).find("maximum depth"), std::string::npos);
}

TEST(Marking, ThirtyRightPicturesAreRight) {
  unsigned seed = 100;
  for (const Exercise& exercise : exercises()) {
    const Image light = sumOfLayers(exercise.student, [](const std::string&, int, int) { return 1; });
    for (const Image& picture :
         {light, grained(light, 0.05, ++seed), grained(light, 0.1, ++seed), grained(light, 0.2, ++seed),
          grained(light, 0.4, ++seed), inEightBits(grained(light, 0.1, ++seed))}) {
      SCOPED_TRACE(exercise.name + ", " + std::to_string(seed));
      const Marking marking = markExercise(picture, exercise.reference);
      EXPECT_TRUE(marking.isRight()) << markingText(marking);
      EXPECT_TRUE(markingStatements(marking).empty());
    }
  }
}

TEST(Marking, NothingWrongIsSaidWithOtherRandomNumbers) {
  // Classes with a hundredth of the light in a few bright pixels seem to be missing in some of these.
  unsigned seed = 1000;
  const auto all = mistakes();
  for (const uint64_t first : {31, 41, 91, 281})
    for (const Exercise& exercise : exercisesOf(first, first + 1)) {
      SCOPED_TRACE(exercise.name + ", " + std::to_string(first));
      const Image light = sumOfLayers(exercise.student, [](const std::string&, int, int) { return 1; });
      const Marking right = markExercise(grained(light, 0.1, ++seed), exercise.reference);
      EXPECT_TRUE(markingStatements(right).empty()) << markingText(right);
      for (const Mistake& mistake : all.at(exercise.name)) {
        const Marking marking = markExercise(pictureOf(exercise, mistake, ++seed), exercise.reference);
        for (const ClassMark& mark : marking.classes) {
          const auto made = mistake.factors.find(mark.name);
          const double factor = made == mistake.factors.end() ? 1 : made->second;
          EXPECT_TRUE(mark.state == stateOf(factor) || mark.state == ClassState::UNKNOWN)
              << mark.name << "\n"
              << markingText(marking);
        }
      }
    }
}

TEST(Marking, MistakeOfHalfThePictureHasItsPart) {
  for (const Exercise& exercise : exercises()) {
    SCOPED_TRACE(exercise.name);
    const Image picture = sumOfLayers(exercise.student, [](const std::string& name, int x, int) {
      return name == "direct-diffuse" && x < 32 ? 0 : 1;
    });
    const Marking marking = markExercise(picture, exercise.reference);
    EXPECT_EQ(marking.change, PictureChange());
    const ClassMark& mark = marking.classes[1];
    EXPECT_EQ(mark.state, ClassState::MISSING) << markingText(marking);
    EXPECT_NEAR(mark.stateFraction, 0.5, 0.15);
    for (const MarkedRegion& region : marking.regions) {
      const ClassState state = region.classes[1].state;
      EXPECT_NE(state, region.x < 32 ? ClassState::RIGHT : ClassState::MISSING)
          << region.x << " " << region.y;
    }
  }
}

TEST(Marking, FactorsAreWithinTheirStandardErrors) {
  const std::vector<Image> light = {waves(1, 9, 0), waves(0.6, 5, 1)};
  double squares = 0;
  constexpr int PICTURES = 20;
  for (unsigned seed = 1; seed <= PICTURES; ++seed) {
    const Stills reference =
        syntheticStills({grained(light[0], 0.3, seed), grained(light[1], 0.3, 100 + seed)}, {"LDE", "LDDE"});
    Image picture = light[0];
    for (size_t i = 0; i < picture.pixels.size(); ++i) picture.pixels[i] += 0.6f * light[1].pixels[i];
    const Marking marking = markExercise(grained(picture, 0.3, 200 + seed), reference);
    EXPECT_EQ(marking.classes[0].state, ClassState::RIGHT) << markingText(marking);
    ASSERT_EQ(marking.classes[1].state, ClassState::SCALED) << markingText(marking);
    squares += std::pow((marking.classes[1].factor - 0.6) / marking.classes[1].standardError, 2);
  }
  // The standard errors include tolerances of bias, so that noise alone is within them.
  EXPECT_LT(squares / PICTURES, 2);
}

TEST(Marking, NoiseOfTheReferenceDoesNotMakeFactorsSmaller) {
  // One layer has nearly as much noise as light: ordinary least squares would give less than nine tenths of
  // its factor.
  const Image steady = waves(1, 9, 0), weak = waves(0.5, 5, 1);
  double sum = 0;
  constexpr int PICTURES = 8;
  for (unsigned seed = 1; seed <= PICTURES; ++seed) {
    const Stills reference = syntheticStills({steady, noisy(weak, 0.4, seed)}, {"LDE", "LS+DE"});
    Image picture = steady;
    for (size_t i = 0; i < picture.pixels.size(); ++i) picture.pixels[i] += 1.5f * weak.pixels[i];
    const Marking marking = markExercise(grained(picture, 0.05, 50 + seed), reference);
    EXPECT_EQ(marking.classes[0].state, ClassState::RIGHT) << markingText(marking);
    sum += marking.classes[1].factor;
  }
  EXPECT_NEAR(sum / PICTURES, 1.5, 0.06);
}

TEST(Marking, ClassesThatLookAlikeAreNotToldApart) {
  Image first = waves(1, 9, 0), second = waves(0.2, 5, 1), third = second;
  const Stills reference = syntheticStills({first, second, third}, {"LDE", "LDDDE", "LDDDDE"});
  Image picture = first;
  for (size_t i = 0; i < picture.pixels.size(); ++i) picture.pixels[i] += second.pixels[i];
  const Marking marking = markExercise(grained(picture, 0.05, 1), reference);
  EXPECT_EQ(marking.classes[0].state, ClassState::RIGHT);
  EXPECT_EQ(marking.classes[1].state, ClassState::UNKNOWN);
  EXPECT_EQ(marking.classes[2].state, ClassState::UNKNOWN);
  ASSERT_EQ(marking.confusions.size(), 1u) << markingText(marking);
  EXPECT_EQ(marking.confusions[0].classes, (std::vector<size_t>{1, 2}));
  EXPECT_FALSE(marking.isRight());
  EXPECT_NE(markingText(marking).find("Either LDDDE is missing"), std::string::npos) << markingText(marking);
}

TEST(Marking, OtherGeometryIsNoClassOfLight) {
  const Exercise& exercise = exercises().front();
  Image picture = sumOfLayers(exercise.student, [](const std::string&, int, int) { return 1; });
  for (int y = 0; y < 32; ++y) // stripes that are in no class
    for (int x = 0; x < 40; ++x)
      for (size_t c = 0; c < 3; ++c) picture.at(x, y)[c] *= (x / 4 + y / 4) % 2 ? 1.6f : 0.4f;
  const Marking marking = markExercise(picture, exercise.reference);
  EXPECT_TRUE(marking.isUnexplained()) << markingText(marking);
  EXPECT_NEAR(marking.unexplainedFraction, 0.4, 0.2);
}

TEST(Marking, SaysWhatCannotBeMarked) {
  const Stills stills = syntheticStills({waves(1, 9, 0), waves(0.5, 5, 1)}, {"LDE", "LDDE"});
  EXPECT_NE(errorOf(Image(8, 8, {"R", "G", "B"}), stills).find("8x8"), std::string::npos);
  EXPECT_NE(errorOf(waves(1, 9, 0), stillsOf(waves(1, 9, 0), "plain")).find("recurse stills"),
            std::string::npos);
  Stills overlapping = stills;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) overlapping.image.at(x, y)[0] *= 0.5f;
  EXPECT_NE(errorOf(waves(1, 9, 0), overlapping).find("do not add up"), std::string::npos);
  Image nothing = waves(1, 9, 0);
  for (float& value : nothing.pixels) value = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NE(errorOf(nothing, stills).find("no part of the picture"), std::string::npos);
}

TEST(Marking, WordsAndJsonSayTheSame) {
  const Exercise& exercise = exercises().back();
  const Marking marking = markExercise(pictureOf(exercise, {{{"caustic", 0}}, {}}, 7), exercise.reference);
  const std::string text = markingText(marking);
  for (const char* part : {"LS+DS*E (caustic) is missing, in 100 % of the picture where it is visible",
                           "lamp, mirror or glass, diffuse or glossy surface, eye", "% sure", "told in"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  const nlohmann::json json = nlohmann::json::parse(markingJson(marking));
  EXPECT_EQ(json["right"], false);
  ASSERT_EQ(json["statements"].size(), 1u);
  EXPECT_NE(text.find(json["statements"][0]["what"]), std::string::npos);
  EXPECT_EQ(json["classes"].size(), exercise.reference.layers.size() - 1);
  EXPECT_EQ(json["classes"][3]["state"], "missing");
  EXPECT_EQ(json["encoding"], "linear");
  EXPECT_EQ(json["regions"].size(), marking.regions.size());
  int covered = 0;
  for (const auto& region : json["regions"]) covered += int(region["width"]) * int(region["height"]);
  EXPECT_EQ(covered, 64 * 48);
}
