/** @file
 * Transient renders: layers of the film by the optical length of paths. The layers add up to the picture, the
 * frames of a light pulse have closed forms, and all estimators agree frame by frame.
 */
#include "classRendering.h"

namespace recurse {
namespace {

using namespace recurse::testing;

PathClasses framed(double from, double to, size_t count) {
  PathClasses classes;
  classes.addFrames({from, to, count});
  return classes;
}

/** The integrators that measure lengths. */
const std::vector<Way> MEASURING = {{"path", ""},
                                    {"simplepath", ""},
                                    {"photonmap", "\"integer photons\" 20000"},
                                    {"photonmap", "\"bool causticsonly\" true \"integer photons\" 20000"},
                                    {"auto", "\"integer photons\" 20000"},
                                    {"simplephotonmap", "\"integer photons\" 20000"},
                                    {"bdpt", ""},
                                    {"vcm", ""}};

/** Layer of a frame: the picture and the light before all frames are first. */
constexpr size_t FIRST_FRAME = 2;

/** The largest difference between the picture and the sum of its other layers, over the brightest value. */
double excess(const Rendered& r) {
  double brightest = 0, largest = 0;
  for (size_t p = 0; p < r.pixels(); ++p)
    for (int c = 0; c < 3; ++c) {
      double sum = 0;
      for (size_t layer = 1; layer < r.film.layerCount(); ++layer) sum += double(r.value(p, layer)[c]);
      brightest = std::max(brightest, double(r.value(p)[c]));
      largest = std::max(largest, std::abs(sum - double(r.value(p)[c])));
    }
  return largest / brightest;
}

/** A diffuse floor at z = 0 seen from straight above by parallel rays that start at z = 5, pixel by pixel 4/size
 * wide, and more of the scene. */
std::string floorFromAbove(int size, const std::string& more) {
  return view(size, size, "0 0 5  0 0 0  0 1 0", "Camera \"orthographic\" \"float screenwindow\" [ -2 2 -2 2 ]") +
         "Material \"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [ -9 -9 0  9 -9 0  -9 9 0  9 9 0 ]\n" +
         more;
}

/** Squared distance from the axis of the middle of a pixel of floorFromAbove(). */
double radius2Of(size_t pixel, int size) {
  const auto at = [&](size_t i) { return (double(i) + 0.5) * 4 / size - 2; };
  return square(at(pixel % size_t(size))) + square(at(pixel / size_t(size)));
}

/** Number of pixels whose light, and no other, is in the frame of length(radius²), as bright as value(radius²).
 * Pixels that a border of frames crosses count half at most. */
template <class Length, class Value>
void expectRings(const Rendered& r, int size, const TransientFrames& frames, const Length& length,
                 const Value& value) {
  const double reach = std::sqrt(2.0) * 2 / size; // from the middle of a pixel to its corners
  size_t clear = 0;
  for (size_t p = 0; p < r.pixels(); ++p) {
    const double radius = std::sqrt(radius2Of(p, size));
    const size_t least = frames.layerOf(float(length(square(std::max(0.0, radius - reach)))));
    const size_t most = frames.layerOf(float(length(square(radius + reach))));
    EXPECT_NEAR(r.luminanceAt(p) / value(square(radius)), 1, 0.02) << p;
    double inside = 0;
    for (size_t layer = std::min(least, most); layer <= std::max(least, most); ++layer)
      inside += r.luminanceAt(p, 1 + layer);
    EXPECT_NEAR(inside / r.luminanceAt(p), 1, 1e-4) << p << ": light at a wrong time";
    clear += least == most;
  }
  EXPECT_GT(clear, r.pixels() / 4) << "pixels within one frame";
}

} // namespace

TEST(Transient, LayersAddUpToThePictureOfTheSameSamples) {
  const auto scene = sceneFrom(glassAndMirrorBox(24));
  const PathClasses classes = framed(6, 12, 12);
  for (const Way& way : MEASURING) {
    const std::string name = way.integrator + " " + way.parameters;
    const Rendered transient = renderClasses(*scene, way, classes, 4, 1);
    const Rendered still = renderClasses(*scene, way, PathClasses(), 4, 1);
    EXPECT_LT(excess(transient), 1e-5) << name;
    for (size_t p = 0; p < still.pixels(); ++p)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(double(transient.value(p)[c]), double(still.value(p)[c]), 1e-4 * double(still.value(p)[c]))
            << name << ", pixel " << p;
    EXPECT_GT(transient.mean(1), 0) << name << ": before the first frame";
    EXPECT_GT(transient.mean(14), 0) << name << ": after the last frame";
  }
}

TEST(Transient, PulseOfAPointLightIsAnExpandingRing) {
  // A lamp of 10 W/sr at a height of 1. Light that arrives at radius r has come sqrt(1 + r²) + 5 far.
  constexpr int SIZE = 32;
  const auto scene = sceneFrom(floorFromAbove(
      SIZE, "LightSource \"point\" \"rgb I\" [ 10 10 10 ] \"point3 from\" [ 0 0 1 ]\n"));
  const PathClasses classes = framed(6, 8, 8);
  const auto length = [](double r2) { return 5 + std::sqrt(1 + r2); };
  const auto value = [](double r2) { return .5 * INV_PI * 10 / std::pow(1 + r2, 1.5); };
  for (const Way& way : std::vector<Way>{{"path", ""}, {"simplepath", ""}, {"bdpt", ""}, {"vcm", ""},
                                         {"photonmap", "\"integer photons\" 1000"}}) {
    SCOPED_TRACE(way.integrator);
    expectRings(renderClasses(*scene, way, classes, 256, 1), SIZE, classes.frames(), length, value);
  }
}

TEST(Transient, EstimatorsAgreeFrameByFrame) {
  const auto scene = sceneFrom(glassAndMirrorBox(12, 0.6));
  const PathClasses classes = framed(5, 14, 9);
  const BatchMeans truth = classMeans(*scene, {"path", ""}, classes, 256, 8);
  for (const Way& way : std::vector<Way>{{"bdpt", ""}, {"vcm", ""}, {"photonmap", "\"integer photons\" 20000"},
                                         {"photonmap", "\"bool causticsonly\" true \"integer photons\" 20000"}}) {
    const BatchMeans means = classMeans(*scene, way, classes, 32, 8);
    for (size_t layer = 0; layer < classes.layerCount(); ++layer) {
      const size_t green = 3 * layer + 1;
      const double error = std::hypot(truth.standardError(green), means.standardError(green));
      EXPECT_NEAR(means.mean(green), truth.mean(green), 5 * error + 0.01 * truth.mean(green))
          << way.integrator << " " << way.parameters << ", layer " << classes.classes()[layer].name;
    }
  }
}

} // namespace recurse
