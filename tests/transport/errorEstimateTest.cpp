/** @file
 * Error estimates of renders: the film's estimate against closed forms and against the true error, and
 * renders that stop at an estimated error.
 */
#include "rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

Rendered untilError(const Scene& scene, const Way& way, double target, int samplesPerPixel = 1 << 14) {
  const ThreadPool pool;
  const auto made = integratorFrom(way.integrator, way.parameters);
  const PathClasses classes;
  Rendered out{Film(scene.film().crop, 1), {}};
  RenderSettings settings;
  settings.samplesPerPixel = samplesPerPixel;
  settings.errorTarget = target;
  const std::atomic<bool> stop{false};
  out.statistics = render(scene, *made, classes, settings, out.film, stop, nullptr, nullptr);
  return out;
}

} // namespace

namespace {

constexpr int WIDTH = 96, SAMPLES = 64;

/** Film of WIDTH x WIDTH pixels, where sample `s` of a pixel in column x has the luminance 1 plus x/WIDTH
 * times `deviation`(sampler of the pixel, s). */
template <class Deviation> Film filmOf(const Deviation& deviation) {
  Film film({0, 0, WIDTH, WIDTH}, 1);
  for (size_t i = 0; i < film.bounds().area(); ++i)
    for (uint32_t s = 0; s < SAMPLES; ++s) {
      const float x = static_cast<float>(i % WIDTH) / WIDTH;
      const Rgb value(1 + x * deviation(Sampler(i, 1, 0), s));
      film.add(i, s, 1, &value, value);
    }
  return film;
}

/** Root mean square of the estimated errors in a column of filmOf(), scaled to deviations of a sample. */
double statedAt(const Film& film, size_t column) {
  const std::vector<double> errors = film.standardErrors();
  double sum = 0;
  for (size_t y = 0; y < WIDTH; ++y) sum += square(errors[y * WIDTH + column]);
  return std::sqrt(sum / WIDTH * SAMPLES) * WIDTH / double(column);
}

float either(Sampler sampler) { return sampler.next1D() < 0.5f ? -1.0f : 1.0f; }

} // namespace

TEST(ErrorEstimate, StandardErrorOfIndependentSamples) {
  PixelBounds bounds;
  bounds.x1 = bounds.y1 = 1;
  EXPECT_TRUE(std::isinf(Film(bounds, 1).relativeError()));
  const Film film = filmOf([](const Sampler& sampler, uint32_t s) { return either(sampler.fork(s)); });
  for (const size_t column : {10u, 50u, 94u}) EXPECT_NEAR(statedAt(film, column), 1, 0.1) << column;
  EXPECT_NEAR(film.relativeError(), 0.95 / std::sqrt(double(SAMPLES)), 0.1 / std::sqrt(double(SAMPLES)));
}

/** Four of eight consecutive samples are too dark and four too bright; the remaining error is common to all
 * eight. */
TEST(ErrorEstimate, StandardErrorOfStratifiedSamplesThatShareAnError) {
  constexpr float SHARED = 0.1f;
  const Film film = filmOf([](const Sampler& sampler, uint32_t s) {
    return (s % 2 == 0 ? -1.0f : 1.0f) + SHARED * either(sampler.fork(s / 8));
  });
  const double truth = double(SHARED) * std::sqrt(8.0);
  for (const size_t column : {10u, 50u, 94u})
    EXPECT_NEAR(statedAt(film, column), truth, 0.15 * truth) << column;
}

/** If light paths add `value` to a pixel with probability q, the mean has the variance value² q (1-q) / n. */
TEST(ErrorEstimate, StandardErrorOfKnownSplats) {
  PixelBounds bounds;
  bounds.x1 = 20;
  bounds.y1 = 1;
  Film film(bounds, 3);
  film.enableSplats(0x1p-30);
  const auto scene = sceneFrom(litCorner(4)); // a scene with a box filter
  constexpr int PATHS = 200;
  const Rgb black[3] = {BLACK, BLACK, BLACK};
  for (size_t i = 0; i < 20; ++i) {
    for (uint32_t s = 0; s < 8; ++s) film.add(i, s, 1, black, BLACK);
    for (size_t k = 0; k < 10 * i; ++k) // a splat into two layers counts once
      film.splat({static_cast<float>(i) + 0.5f, 0.5f}, scene->filter(), 5, Rgb(3));
  }
  film.splats()->addPaths(PATHS);
  const std::vector<double> errors = film.standardErrors();
  for (size_t i = 0; i < 20; ++i) {
    const double q = double(i) / 20;
    EXPECT_NEAR(film.luminanceOf(i), 3 * q, 1e-6) << i;
    EXPECT_NEAR(errors[i], 3 * std::sqrt(q * (1 - q) / (PATHS - 1)), 1e-6) << i;
  }
  EXPECT_GT(film.relativeError(), 0.1);
  Film twice(bounds, 3);
  twice.add(film);
  twice.add(film);
  EXPECT_NEAR(twice.standardErrors()[10], errors[10] / std::sqrt(2.0 * (2 * PATHS - 1) / (2 * PATHS - 2)),
              1e-6);
}

/** Few samples find a lamp; most pixels are black. */
TEST(ErrorEstimate, OfLightThatFewSamplesFind) {
  constexpr float CHANCE = 1.0f / 1024;
  Film film({0, 0, WIDTH, WIDTH}, 1);
  for (size_t i = 0; i < film.bounds().area(); ++i)
    for (uint32_t s = 0; s < SAMPLES; ++s) {
      const Rgb value(Sampler(i, 1, 0).fork(s).next1D() < CHANCE ? 1 / CHANCE : 0);
      film.add(i, s, 1, &value, value);
    }
  const double truth = std::sqrt((1 / double(CHANCE) - 1) / SAMPLES); // relative to the mean of 1
  EXPECT_NEAR(film.relativeError(), truth, 0.5 * truth);
}

/** What lies far from a small lit object is black and without error. */
TEST(ErrorEstimate, CountsBlackPixelsNearOthersOnly) {
  Film film({0, 0, WIDTH, WIDTH}, 1);
  for (size_t i = 0; i < film.bounds().area(); ++i)
    for (uint32_t s = 0; s < SAMPLES; ++s) {
      const bool isLit = i % WIDTH < 8 && i / WIDTH < 8;
      const Rgb value(isLit ? 1 + 0.5f * either(Sampler(i, 1, 0).fork(s)) : 0);
      film.add(i, s, 1, &value, value);
    }
  const double ofObject = 0.5 / std::sqrt(double(SAMPLES));
  EXPECT_EQ(film.standardErrors().back(), 0);
  EXPECT_GT(film.relativeError(), 0.9 * ofObject);
  EXPECT_LT(film.relativeError(), 4 * ofObject);
}

TEST(ErrorEstimate, IsNearTheTrueError) {
  const auto scene = sceneFrom(litCorner(24));
  const Rendered truth = renderScene(*scene, "path", "", samples(4096), 5);
  const std::vector<double> errorsOfTruth = truth.film.standardErrors();
  for (const auto& [integrator, parameters] : dealt(allWays("20000"), 0)) {
    double squares = 0, stated = 0;
    constexpr int RENDERS = 4;
    for (uint64_t seed = 0; seed < RENDERS; ++seed) {
      const Rendered some = renderScene(*scene, integrator, parameters, 64, seed);
      const std::vector<double> errors = some.film.standardErrors();
      for (size_t p = 0; p < some.pixels(); ++p) {
        squares += double(square(luminance(some.value(p)) - luminance(truth.value(p))));
        stated += square(errors[p]) + square(errorsOfTruth[p]);
      }
    }
    // Direct light without occlusion is stratified over more samples than a batch has.
    const double ratio = std::sqrt(squares / stated);
    EXPECT_GT(ratio, 0.33) << integrator << parameters;
    EXPECT_LT(ratio, 1.15) << integrator << parameters;
  }
}

/** Pixels of `lightpath` are only splats; the lamp itself is not visible in them. */
TEST(ErrorEstimate, IsNearTheTrueErrorOfSplats) {
  const auto scene = sceneFrom(view(16, "0 0 3  0 0 0  0 1 0", 40) + R"(
Shape "disk" "float radius" 3
LightSource "point" "point3 from" [ .5 0 2 ])");
  const Rendered truth = renderScene(*scene, "path", "", samples(1024), 5);
  const Rendered some = renderScene(*scene, "lightpath", "\"integer lightpaths\" 10000", 32);
  const std::vector<double> errors = some.film.standardErrors();
  double squares = 0;
  for (size_t p = 0; p < some.pixels(); ++p)
    squares += double(square(luminance(some.value(p)) - luminance(truth.value(p)))) / square(errors[p]);
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
