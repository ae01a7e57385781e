/** @file
 * A render knows its own error: the film's estimate against closed forms and against the truth, and renders
 * that end by it.
 */
#include "rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

Rendered untilError(const Scene& scene, const Way& way, double target, int samplesPerPixel = 0) {
  const ThreadPool pool;
  const auto made = integratorFrom(way.integrator, way.parameters);
  const PathClasses classes;
  Rendered out{Film(scene.film().crop, 1), {}};
  RenderSettings settings;
  settings.samplesPerPixel = samplesPerPixel;
  settings.errorTarget = target;
  settings.timeLimit = 60;
  const std::atomic<bool> stop{false};
  out.statistics = render(scene, *made, classes, settings, out.film, stop, nullptr, nullptr);
  return out;
}

} // namespace

TEST(ErrorEstimate, StandardErrorOfKnownSamples) {
  PixelBounds bounds;
  bounds.x1 = 100;
  bounds.y1 = 1;
  Film film(bounds, 1);
  EXPECT_TRUE(std::isinf(film.relativeError()));
  // Half of the samples of pixel i are 1 - i/100, half are 1 + i/100: luminance 1, deviation i/100.
  for (size_t i = 0; i < 100; ++i)
    for (int s = 0; s < 64; ++s) {
      const Rgb value(1 + (s % 2 == 0 ? -1.0f : 1.0f) * static_cast<float>(i) / 100);
      film.add(i, 1, &value, value);
    }
  for (size_t i = 0; i < 100; ++i)
    EXPECT_NEAR(film.standardError(i), double(i) / 100 / std::sqrt(63.0), 1e-6) << i;
  EXPECT_NEAR(film.relativeError(), 0.94 / std::sqrt(63.0), 1e-6);
}

/** Of light paths that bring `value` to a pixel with chance q, the mean has the variance value² q (1-q) / n.
 */
TEST(ErrorEstimate, StandardErrorOfKnownSplats) {
  PixelBounds bounds;
  bounds.x1 = 20;
  bounds.y1 = 1;
  Film film(bounds, 3);
  film.enableSplats(0x1p-30);
  const auto scene = sceneFrom(litCorner(4)); // which has a box filter
  constexpr int PATHS = 200;
  const Rgb black[3] = {BLACK, BLACK, BLACK};
  for (size_t i = 0; i < 20; ++i) {
    for (int s = 0; s < 8; ++s) film.add(i, 1, black, BLACK);
    for (size_t k = 0; k < 10 * i; ++k) // in two layers, which count once
      film.splat({static_cast<float>(i) + 0.5f, 0.5f}, scene->filter(), 5, Rgb(3));
  }
  film.splats()->addPaths(PATHS);
  for (size_t i = 0; i < 20; ++i) {
    const double q = double(i) / 20;
    EXPECT_NEAR(film.luminanceOf(i), 3 * q, 1e-6) << i;
    EXPECT_NEAR(film.standardError(i), 3 * std::sqrt(q * (1 - q) / (PATHS - 1)), 1e-6) << i;
  }
  EXPECT_GT(film.relativeError(), 0.1);
  Film twice(bounds, 3);
  twice.add(film);
  twice.add(film);
  EXPECT_NEAR(twice.standardError(10),
              film.standardError(10) / std::sqrt(2.0 * (2 * PATHS - 1) / (2 * PATHS - 2)), 1e-6);
}

TEST(ErrorEstimate, IsNearTheTrueError) {
  const auto scene = sceneFrom(litCorner(16));
  const Rendered truth = renderScene(*scene, "path", "", samples(4096), 5);
  for (const char* integrator : {"path", "sppm", "bdpt", "vcm"}) {
    const Rendered some = renderScene(*scene, integrator, "", 32);
    double squares = 0;
    for (size_t p = 0; p < some.pixels(); ++p) {
      ASSERT_GT(some.film.standardError(p), 0);
      squares += double(square(luminance(some.value(p)) - luminance(truth.value(p)))) /
                 (square(some.film.standardError(p)) + square(truth.film.standardError(p)));
    }
    // Stratification makes the true error smaller than the samples' spread says.
    const double ratio = std::sqrt(squares / double(some.pixels()));
    EXPECT_GT(ratio, 0.2) << integrator;
    EXPECT_LT(ratio, 1.2) << integrator;
  }
}

/** The pixels of `lightpath` are all splats; without the lamp, which it does not see. */
TEST(ErrorEstimate, IsNearTheTrueErrorOfSplats) {
  const auto scene = sceneFrom(view(16, "0 0 3  0 0 0  0 1 0", 40) + R"(
Shape "disk" "float radius" 3
LightSource "point" "point3 from" [ .5 0 2 ])");
  const Rendered truth = renderScene(*scene, "path", "", samples(1024), 5);
  const Rendered some = renderScene(*scene, "lightpath", "\"integer lightpaths\" 10000", 32);
  double squares = 0;
  for (size_t p = 0; p < some.pixels(); ++p)
    squares += double(square(luminance(some.value(p)) - luminance(truth.value(p)))) /
               square(some.film.standardError(p));
  // Light paths are stratified as well.
  const double ratio = std::sqrt(squares / double(some.pixels()));
  EXPECT_GT(ratio, 0.3);
  EXPECT_LT(ratio, 1.1);
}

TEST(ErrorEstimate, EndsARender) {
  const auto scene = sceneFrom(litCorner(16));
  for (const Way& way : {Way{"path", ""}, Way{"photonmap", "\"integer passes\" 1 \"integer photons\" 20000"},
                         Way{"bdpt", ""}, Way{"lightpath", ""}}) {
    const Rendered r = untilError(*scene, way, 0.15);
    EXPECT_EQ(r.statistics.stopReason, StopReason::ERROR) << way.integrator;
    EXPECT_LE(r.statistics.error, 0.15);
    EXPECT_GT(r.statistics.error, 0.02) << "went on for too long";
    EXPECT_EQ(r.statistics.error, r.film.relativeError());
    EXPECT_EQ(untilError(*scene, way, 1e-6, 9).statistics.stopReason, StopReason::SAMPLES);
  }
}
