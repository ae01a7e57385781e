/** @file
 * Lens systems against matrices of paraxial rays.
 */
#include <cstdio>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include "cameras/realistic/lensSystem.h"
#include "recurse/core/sampling/sampler.h"
#include "recurse/model/scene/plugIns.h"

using namespace recurse;

namespace {

/** A double Gauss of 50 mm, as in scenes/lenses; the stop is the sixth. [m] */
std::vector<LensSurface> doubleGauss(double stopRadius) {
  const double rows[][4] = {{29.475, 3.76, 1.67, 25.2}, {84.83, 0.12, 1, 25.2},    {19.275, 4.025, 1.67, 23},
                            {40.77, 3.275, 1.699, 23},  {12.75, 5.705, 1, 18},     {0, 4.5, 1, 17.1},
                            {-14.495, 1.18, 1.603, 17}, {40.77, 6.065, 1.658, 20}, {-20.385, 0.19, 1, 20},
                            {437.065, 3.22, 1.717, 20}, {-39.73, 0, 1, 20}};
  std::vector<LensSurface> all;
  for (const auto& r : rows) all.push_back({r[0] / 1000, r[1] / 1000, r[2], r[3] / 2000});
  for (LensSurface& s : all)
    if (s.isStop()) s.apertureRadius = stopRadius;
  return all;
}

/** Matrix of (height, angle times index) from behind surface `last` to the front of surface `first`, towards
 * the scene. */
glm::dmat2 towardsScene(const std::vector<LensSurface>& lens, size_t last, size_t first) {
  glm::dmat2 m(1);
  for (size_t i = last + 1; i-- > first;) {
    const double before = i > 0 ? lens[i - 1].index : 1, after = lens[i].index;
    if (i < last) m = glm::dmat2(1, 0, lens[i].thickness / after, 1) * m;
    // The ray arrives from behind, and a positive radius has its centre behind the surface.
    const double power = lens[i].isStop() ? 0 : (after - before) / lens[i].radius;
    m = glm::dmat2(1, -power, 0, 1) * m;
  }
  return m;
}

constexpr double FOCUS = 1.7, STOP = 0.0015;

} // namespace

TEST(LensSystem, FilmPlacesAreImagedToTheDistanceInFocusAtTheScaleOfTheMatrices) {
  const std::vector<LensSurface> surfaces = doubleGauss(STOP);
  for (const double distance : {0.4, 1.0, FOCUS, 100.0}) {
    const LensSystem lens(surfaces, distance);
    double front = lens.rearZ(); // the first surface, from the film
    for (size_t i = 0; i + 1 < surfaces.size(); ++i) front += surfaces[i].thickness;
    const glm::dmat2 m = towardsScene(surfaces, surfaces.size() - 1, 0);
    // From the film to the plane in focus: the height there does not depend on the angle at the film.
    const glm::dmat2 whole = glm::dmat2(1, 0, distance - front, 1) * m * glm::dmat2(1, 0, lens.rearZ(), 1);
    EXPECT_NEAR(whole[1][0], 0, 1e-6 * distance);
    for (const double height : {0.0, 1e-3}) {
      for (const double up : {-1e-3, 1e-3}) {
        const Vec3d from(height, 0, 0), to(height / 2, up, lens.rearZ());
        const auto ray = lens.trace({from, glm::normalize(to - from)});
        ASSERT_TRUE(ray);
        const Vec3d there = ray->origin + ray->direction * ((distance - ray->origin.z) / ray->direction.z);
        EXPECT_NEAR(there.x, whole[0][0] * height, 0.01 * std::abs(whole[0][0]) * 1e-3) << distance;
        EXPECT_NEAR(there.y, 0, 0.01 * std::abs(whole[0][0]) * 1e-3) << distance;
      }
    }
  }
}

TEST(LensSystem, FocusesNoNearerThanFourFocalLengths) {
  EXPECT_NEAR(LensSystem(doubleGauss(STOP), FOCUS).focalLength(), 0.05, 1e-3);
  try {
    const LensSystem lens(doubleGauss(STOP), 0.15);
    ADD_FAILURE();
  } catch (const LensSystem::CannotFocus& e) {
    EXPECT_NO_THROW(LensSystem(doubleGauss(STOP), e.nearest * 1.0001));
    EXPECT_THROW(LensSystem(doubleGauss(STOP), e.nearest * 0.9999), LensSystem::CannotFocus);
  }
  const std::vector<LensSurface> diverging = {{-0.02, 0.002, 1.5, 0.01}, {0.02, 0, 1, 0.01}};
  EXPECT_THROW(LensSystem(diverging, 1), LensSystem::CannotFocus);
}

TEST(RealisticCamera, EvenLightFillsTheExitPupil) {
  // At the centre of the film the irradiance is π sin² of half the angle of the exit pupil, which is the
  // image of the stop through the surfaces behind it.
  const std::vector<LensSurface> surfaces = doubleGauss(STOP);
  const LensSystem lens(surfaces, FOCUS);
  const size_t stop = 5, last = surfaces.size() - 1;
  // From the film to the stop, for rays from a point of the film: height = toStop[1][0] · angle.
  const glm::dmat2 toStop = glm::dmat2(1, 0, surfaces[stop].thickness, 1) *
                            towardsScene(surfaces, last, stop + 1) * glm::dmat2(1, 0, lens.rearZ(), 1);
  const double tangent = STOP / std::abs(toStop[1][0]);
  CameraContext context;
  context.width = 61;
  context.height = 41;
  Diagnostics diagnostics;
  const auto camera =
      plugIns().cameras.make(parseParameterText("realistic", "\"string lensfile\" \"" RECURSE_SOURCE_DIR
                                                             "/scenes/lenses/double-gauss.dat\" "
                                                             "\"float aperturediameter\" 3 "
                                                             "\"float focusdistance\" 1.7"),
                             context, diagnostics);
  ASSERT_TRUE(camera) << diagnostics.format();
  const auto irradiance = [&](const Vec2f& film) {
    double sum = 0;
    constexpr uint32_t N = 1 << 15;
    for (uint32_t i = 0; i < N; ++i) {
      Sampler sampler(1, 7, i);
      if (const auto ray = camera->sampleRay({film, sampler.next2D()})) sum += double(ray->weight) / N;
    }
    return sum;
  };
  const double middle = irradiance({30.5f, 20.5f});
  EXPECT_NEAR(middle, M_PI * square(tangent) / (1 + square(tangent)), 0.02 * middle);
  // Towards a corner the irradiance decreases at least with the fourth power of the cosine.
  const double corner = irradiance({0.5f, 0.5f});
  EXPECT_GT(corner, 0.1 * middle);
  EXPECT_LT(corner, 0.9 * middle);
  EXPECT_NEAR(irradiance({60.5f, 40.5f}), corner, 0.02 * middle);
}

TEST(RealisticCamera, AWrongSurfaceIsToldByItsOwnLine) {
  const std::string name = ::testing::TempDir() + "lens" + std::to_string(::getpid()) + ".dat";
  const auto says = [&](const std::string& text) {
    std::ofstream(name) << text;
    CameraContext context;
    context.width = context.height = 10;
    Diagnostics diagnostics;
    plugIns().cameras.make(parseParameterText("realistic", "\"string lensfile\" \"" + name + "\""), context,
                           diagnostics);
    std::remove(name.c_str());
    return diagnostics.format();
  };
  // Three numbers: the diameter is read from the next line.
  const std::string shortLine = says("20 3 1.5\n-20 1 0 5\n");
  EXPECT_NE(shortLine.find("line 1: a lens without a diameter"), std::string::npos) << shortLine;
  const std::string end = says("# a comment\n20 3 1.5 5\n-20 1 0\n");
  EXPECT_NE(end.find("line 3: the last surface is incomplete"), std::string::npos) << end;
}

TEST(RealisticCamera, PicturesAreUpright) {
  CameraContext context;
  context.width = context.height = 10;
  Diagnostics diagnostics;
  const auto camera =
      plugIns().cameras.make(parseParameterText("realistic", "\"string lensfile\" \"" RECURSE_SOURCE_DIR
                                                             "/scenes/lenses/double-gauss.dat\""),
                             context, diagnostics);
  ASSERT_TRUE(camera) << diagnostics.format();
  for (const Vec2f& at : {Vec2f(1, 1), Vec2f(9, 1), Vec2f(3, 8)}) {
    const auto ray = camera->sampleRay({at});
    ASSERT_TRUE(ray);
    EXPECT_GT(ray->direction.z, 0.5f);
    EXPECT_GT(ray->direction.x * (at.x - 5), 0);
    EXPECT_LT(ray->direction.y * (at.y - 5), 0);
  }
}

TEST(RealisticCamera, ImpossibleLensesAreErrors) {
  const std::string file = ::testing::TempDir() + "/lens.dat";
  const auto error = [&](const std::string& text) {
    std::ofstream(file) << text;
    CameraContext context;
    context.width = context.height = 10;
    Diagnostics diagnostics;
    EXPECT_FALSE(plugIns().cameras.make(
        parseParameterText("realistic", "\"string lensfile\" \"" + file + "\""), context, diagnostics));
    return diagnostics.format();
  };
  const auto expect = [&](const std::string& text, const std::string& what) {
    const std::string message = error(text);
    EXPECT_NE(message.find(what), std::string::npos) << message;
  };
  expect("", "no surfaces");
  expect("# nothing\n20 1 1.5", "incomplete");
  expect("20 1 glass 10", "\"glass\" is not a number");
  expect("20 1 0.2 10", "impossible glass");
  expect("20 -1 1.5 10", "wrong order");
  expect("20 1 1.5 0", "without a diameter");
  expect("-20 1 1.5 10 20 0 1 10", "do not converge");
  expect("20 1 1.5 10 -20 0 1.5 10", "the medium behind the last surface is not air");
}
