/** @file
 * Marks of pictures whose classes are wrong in parts only, by a limited depth, and of pictures whose values
 * are not light: by tone operators, curves and clipping.
 */
#include <gtest/gtest.h>

#include <cmath>

#include "recurse/model/scene/plugIns.h"
#include "recurse/report/develop/develop.h"
#include "recurse/report/marking/marking.h"
#include "report/marking/fittedCurve.h"
#include "report/markingPictures.h"
#include "report/markingScenes.h"

using namespace recurse;
using namespace markingPictures;

namespace {

Image plainPicture(const Stills& stills) {
  return sumOfLayers(stills, [](const std::string&, int, int) { return 1; });
}

/** Light of a class in a picture over its light in the reference; 1 where it has none. */
double lightRatio(const Stills& picture, const Stills& reference, size_t layer) {
  double light = 0, all = 0;
  for (int y = 0; y < picture.image.height; ++y)
    for (int x = 0; x < picture.image.width; ++x)
      for (size_t c = 0; c < 3; ++c) {
        light += double(picture.image.at(x, y)[3 * layer + c]);
        all += double(reference.image.at(x, y)[3 * layer + c]);
      }
  return all > 0 ? light / all : 1;
}

/** No class is said to be in a state that it is not in. */
void expectNoFalseVerdict(const Marking& marking, const Stills& student, const Stills& reference) {
  constexpr double NOTHING = 0.05, ALL = 0.95;
  for (size_t i = 0; i < marking.classes.size(); ++i) {
    const ClassMark& mark = marking.classes[i];
    const double ratio = lightRatio(student, reference, i + 1);
    SCOPED_TRACE(mark.name + ", true ratio " + std::to_string(ratio));
    EXPECT_NE(mark.state, ClassState::DOUBLED);
    if (ratio < NOTHING) {
      EXPECT_TRUE(mark.state == ClassState::MISSING || mark.state == ClassState::UNKNOWN);
    }
    if (ratio > ALL) {
      EXPECT_TRUE(mark.state == ClassState::RIGHT || mark.state == ClassState::UNKNOWN);
    }
    if (mark.state == ClassState::SCALED) {
      EXPECT_LT(mark.factor, 1);
    }
  }
}

/** Picture by a tone operator with default parameters, as a PNG file brings it back. */
Image toneMapped(const Image& light, const std::string& name) {
  DevelopSettings settings;
  Diagnostics diagnostics;
  settings.toneMap = plugIns().toneMaps.make(parseParameterText(name, ""), NoContext{}, diagnostics);
  diagnostics.throwIfErrors();
  Image out = develop(light, settings).picture;
  out.fromIntegers = true;
  for (float& value : out.pixels) value = linearFromSrgb(std::round(255 * value) / 255);
  return out;
}

/** Root mean square of the deviation of ln(value / light) from its mean, over channels that are neither black
 * nor clipped. */
double nonlinearityOf(const Image& picture, const Image& light) {
  double sum = 0, squares = 0, count = 0;
  for (size_t i = 0; i < light.pixels.size(); ++i) {
    constexpr float DARK = 0.01f, CLIPPED = 0.99f;
    if (light.pixels[i] < DARK || picture.pixels[i] < DARK || picture.pixels[i] > CLIPPED) continue;
    const double ratio = std::log(double(picture.pixels[i] / light.pixels[i]));
    sum += ratio;
    squares += ratio * ratio;
    ++count;
  }
  return std::sqrt(squares / count - sum * sum / (count * count));
}

Image scaled(Image image, float factor) {
  for (float& value : image.pixels) value *= factor;
  return image;
}

} // namespace

TEST(MarkingReading, LimitedDepthIsMissingClasses) {
  for (const auto& [name, scene] : {std::pair<std::string, std::string>{"room", markingScenes::room()},
                                    {"glass", markingScenes::glass()}})
    for (const std::string integrator : {"path", "photonmap"}) {
      const Stills reference = renderedStills(scene, integrator == "path" ? 128 : 32, 1, integrator);
      for (int depth = 1; depth <= 4; ++depth) {
        const Stills student =
            renderedStills(scene, 128, 3, "path", "\"integer maxdepth\" " + std::to_string(depth));
        const Marking marking = markExercise(plainPicture(student), reference);
        SCOPED_TRACE(name + " by " + integrator + ", depth " + std::to_string(depth) + "\n" +
                     markingText(marking));
        EXPECT_EQ(marking.change, PictureChange());
        EXPECT_GT(marking.changeCertainty, 0.9);
        EXPECT_EQ(marking.exposureError, 0);
        EXPECT_EQ(marking.classes[1].name, "direct-diffuse");
        EXPECT_EQ(marking.classes[1].state, ClassState::RIGHT);
        expectNoFalseVerdict(marking, student, reference);
        if (name == "room" && depth <= 2) {
          EXPECT_EQ(marking.classes[3 + size_t(depth)].state, ClassState::MISSING)
              << marking.classes[3 + size_t(depth)].name;
        }
      }
    }
}

TEST(MarkingReading, ToneOperatorsAreFoundAndNoClassIsJudged) {
  using namespace markingScenes;
  int found = 0;
  for (const auto& [name, scene] : {std::pair<std::string, std::string>{"room", room()},
                                    {"outdoors", outdoors()},
                                    {"mirror", wallWithMirror()},
                                    {"corner", corner()},
                                    {"glass", glass()}}) {
    const Stills reference = renderedStills(scene, 128, 1);
    const Image light = plainPicture(renderedStills(scene, 128, 2));
    for (const auto& entry : plugIns().toneMaps.entries()) {
      const Image picture = toneMapped(light, entry.name);
      const double nonlinearity = nonlinearityOf(picture, light);
      const Marking marking = markExercise(picture, reference);
      SCOPED_TRACE(name + ", " + entry.name + ", nonlinearity " + std::to_string(nonlinearity) + "\n" +
                   markingText(marking));
      // Whatever is said of the values, no class is wrong.
      for (const ClassMark& mark : marking.classes)
        EXPECT_TRUE(mark.state == ClassState::RIGHT || mark.state == ClassState::UNKNOWN) << mark.name;
      EXPECT_LE(markingStatements(marking).size(), 1u);
      // Some operators change nothing but the exposure of a picture of low contrast.
      constexpr double LINEAR = 0.01, VISIBLE = 0.1;
      if (nonlinearity < LINEAR) {
        EXPECT_EQ(marking.change, PictureChange());
      }
      if (nonlinearity > VISIBLE) {
        EXPECT_EQ(marking.change, PictureChange{.encoding = ValueEncoding::TONE_CURVE});
        EXPECT_GT(marking.changeCertainty, 0.9);
        ++found;
      }
    }
  }
  EXPECT_GT(found, 20);
}

TEST(MarkingReading, ToneCurveOnTopOfALimitedDepthIsFound) {
  const Stills reference = renderedStills(markingScenes::room(), 128, 1);
  for (const std::string depth : {"2"}) {
    const Image light =
        plainPicture(renderedStills(markingScenes::room(), 128, 3, "path", "\"integer maxdepth\" " + depth));
    for (const std::string name : {"filmic", "aces", "reinhard", "drago"}) {
      const Image picture = toneMapped(light, name);
      const Marking marking = markExercise(picture, reference);
      SCOPED_TRACE("depth " + depth + ", " + name + "\n" + markingText(marking));
      EXPECT_EQ(marking.change, PictureChange{.encoding = ValueEncoding::TONE_CURVE});
      for (const ClassMark& mark : marking.classes) EXPECT_EQ(mark.state, ClassState::UNKNOWN) << mark.name;
    }
  }
}

TEST(MarkingReading, EmissionAloneIsNoToneCurve) {
  const Stills reference = renderedStills(markingScenes::corner(), 128, 1);
  const Image picture =
      sumOfLayers(reference, [](const std::string& name, int, int) { return name == "emitted" ? 1 : 0; });
  const Marking marking = markExercise(picture, reference);
  EXPECT_EQ(marking.change, PictureChange()) << markingText(marking);
  EXPECT_EQ(marking.classes[1].state, ClassState::MISSING);
}

TEST(MarkingReading, FittedCurveIsTheCurve) {
  const Image light = waves(0.5, 5, 1);
  Image shown = light;
  for (float& value : shown.pixels) value = value / (0.3f + value);
  const FittedCurve curve(shown, light, CurveDomain::CHANNELS, 2);
  ASSERT_TRUE(curve.isKnown());
  const Image found = curve.shown(light), back = curve.light(found);
  double sum = 0;
  for (size_t i = 0; i < light.pixels.size(); ++i) {
    const double error = std::abs(double(found.pixels[i] / shown.pixels[i]) - 1);
    sum += error;
    EXPECT_LT(error, 0.04);
    EXPECT_NEAR(back.pixels[i], light.pixels[i], 0.02 * double(light.pixels[i]));
  }
  EXPECT_LT(sum / double(light.pixels.size()), 0.01);
}

TEST(MarkingReading, ExposureOfClippedPicturesIsRight) {
  for (const auto& [name, scene] : {std::pair<std::string, std::string>{"room", markingScenes::room()},
                                    {"corner", markingScenes::corner()}}) {
    const Stills reference = renderedStills(scene, 128, 1);
    const Image light = plainPicture(renderedStills(scene, 64, 2));
    for (const float exposure : {0.5f, 2.0f, 3.0f}) {
      const Marking marking = markExercise(inEightBits(scaled(light, exposure)), reference);
      SCOPED_TRACE(name + ", " + std::to_string(exposure) + "\n" + markingText(marking));
      EXPECT_EQ(marking.change, PictureChange());
      EXPECT_NEAR(marking.exposure, double(exposure), 0.02 * double(exposure));
      for (const ClassMark& mark : marking.classes) {
        EXPECT_TRUE(mark.state == ClassState::RIGHT || mark.state == ClassState::UNKNOWN) << mark.name;
        if (mark.state == ClassState::RIGHT) {
          EXPECT_GT(mark.standardError, 0) << mark.name;
        }
      }
    }
  }
}

TEST(MarkingReading, GammaOnTopOfSrgbIsAnEncoding) {
  for (const std::string& scene : {markingScenes::room(), markingScenes::glass()}) {
    const Stills reference = renderedStills(scene, 128, 1);
    Image picture = plainPicture(renderedStills(scene, 128, 2));
    picture.fromIntegers = true;
    for (float& value : picture.pixels) {
      const float twice = std::pow(srgbFromLinear(std::clamp(value, 0.0f, 1.0f)), 1 / 2.2f);
      value = linearFromSrgb(std::round(255 * twice) / 255);
    }
    const Marking marking = markExercise(picture, reference);
    SCOPED_TRACE(markingText(marking));
    EXPECT_TRUE(marking.change.encoding == ValueEncoding::SRGB ||
                marking.change.encoding == ValueEncoding::GAMMA_22);
    EXPECT_EQ(markingStatements(marking).size(), 1u);
  }
}

TEST(MarkingReading, ClassWhoseBrightPixelsAreClippedIsNotJudged) {
  const Image direct = waves(0.3, 9, 0);
  Image caustic = waves(0.06, 5, 1);
  for (int y = 0; y < caustic.height; ++y)
    for (int x = 0; x < caustic.width; ++x)
      if (x < 16 || x >= 32) std::fill_n(caustic.at(x, y), 3, 0.0f);
  const Stills reference = syntheticStills({direct, caustic}, {"LDE", "LS+DE"});
  // All of the caustic in one pixel of thirty.
  std::mt19937 generator(1);
  Image picture = direct;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if (generator() % 30 == 0)
        for (size_t c = 0; c < 3; ++c) picture.at(x, y)[c] += 30 * caustic.at(x, y)[c];
  const Marking right = markExercise(picture, reference);
  EXPECT_TRUE(right.isRight()) << markingText(right);
  const Marking clipped = markExercise(inEightBits(picture), reference);
  SCOPED_TRACE(markingText(clipped));
  EXPECT_EQ(clipped.classes[0].state, ClassState::RIGHT);
  EXPECT_EQ(clipped.classes[1].state, ClassState::UNKNOWN);
}
