/** @file
 * Properties of every registered camera, and the thin lens against its equation.
 */
#include <gtest/gtest.h>

#include "recurse/core/sampling/sampler.h"
#include "recurse/model/film/film.h"
#include "recurse/model/scene/plugIns.h"

using namespace recurse;

namespace {

Mat4d moved(double turn, const Vec3d& scale, const Vec3d& to) {
  Mat4d m(1);
  m[0] = Vec4d(std::cos(turn), std::sin(turn), 0.3, 0) * scale.x;
  m[1] = Vec4d(-std::sin(turn), std::cos(turn), 0, 0) * scale.y;
  m[2] = Vec4d(-0.3 * std::cos(turn), -0.3 * std::sin(turn), 1, 0) * scale.z;
  m[3] = Vec4d(to, 1);
  return m;
}

constexpr int WIDTH = 12, HEIGHT = 8;

std::unique_ptr<Camera> makeCamera(const std::string& name, const std::string& parameters,
                                   const Mat4d& sceneFromCamera) {
  CameraContext context;
  context.sceneFromCamera = sceneFromCamera;
  context.width = WIDTH;
  context.height = HEIGHT;
  Diagnostics diagnostics;
  auto camera = plugIns().cameras.make(parseParameterText(name, parameters), context, diagnostics);
  EXPECT_TRUE(camera) << diagnostics.format();
  return camera;
}

/** Calls `check(camera, words)` for each example of each camera, at several positions and sizes. */
template <class Check> void forEachCamera(const Check& check) {
  const Mat4d places[] = {Mat4d(1), moved(0.4, Vec3d(3), {5, -2, 1}), moved(2, {0.5, -0.5, 0.5}, {0, 1, 0}),
                          moved(1, {1, 2, 1.5}, {0, 0, 2})};
  for (const auto& entry : plugIns().cameras.entries())
    for (const std::string& example : entry.examples)
      for (size_t i = 0; i < std::size(places); ++i) {
        const auto camera = makeCamera(entry.name, example, places[i]);
        if (camera) check(*camera, entry.name + " " + example + ", place " + std::to_string(i));
      }
}

} // namespace

TEST(Cameras, APointOnARayIsConnectedToTheRaysPlaceOfFilmAndLens) {
  forEachCamera([](const Camera& camera, const std::string& words) {
    if (!camera.isConnectable()) return;
    for (uint32_t i = 0; i < 500; ++i) {
      Sampler sampler(1, 2, i);
      const CameraSample sample{sampler.next2D() * Vec2f(WIDTH, HEIGHT), sampler.next2D()};
      const auto ray = camera.sampleRay(sample);
      ASSERT_TRUE(ray) << words;
      const float distance = 0.1f + 5 * sampler.next1D();
      const auto wi = camera.sampleWi(ray->at(distance), sample.lens, 0);
      ASSERT_TRUE(wi) << words;
      EXPECT_LT(glm::distance(wi->film, sample.film), 2e-3f) << words;
      EXPECT_LT(glm::distance(wi->position, ray->origin), 1e-4f) << words;
      EXPECT_LT(glm::distance(wi->direction, -ray->direction), 1e-4f) << words;
      EXPECT_NEAR(wi->distance, distance, 1e-4f) << words;
      EXPECT_GT(camera.pdfWe(*ray).direction, 0) << words;
    }
  });
}

TEST(Cameras, DirectionsOfAPinholeHaveTheFilmsSolidAngle) {
  // The mean over samples of 1 / density is the measure of the domain.
  const double a = std::tan(0.4) * WIDTH / HEIGHT, b = std::tan(0.4);
  const double solidAngle = 4 * std::atan(a * b / std::sqrt(1 + a * a + b * b));
  for (const double scale : {0.1, 1.0, 7.0}) {
    const auto camera =
        makeCamera("perspective", "\"float fov\" " + std::to_string(0.8 * 180 / M_PI), Mat4d(Mat3d(scale)));
    double sum = 0;
    constexpr uint32_t N = 1 << 12;
    for (uint32_t i = 0; i < N; ++i) {
      Sampler sampler(1, 3, i);
      const auto ray = camera->sampleRay({sampler.next2D() * Vec2f(WIDTH, HEIGHT)});
      sum += 1 / double(camera->pdfWe(*ray).direction) / N;
    }
    EXPECT_NEAR(sum, solidAngle, 1e-3 * solidAngle);
  }
}

TEST(Cameras, SplattingALitPlaneEqualsViewingIt) {
  // A large plane across the view whose radiance varies with position and direction. Its points are sampled
  // by area and splatted; in the second picture camera rays hit it.
  const Vec3f normal = glm::normalize(Vec3f(0.2f, -0.1f, -1));
  const auto radiance = [&](const Vec3f& p, const Vec3f& out) {
    return (1 + 0.5f * std::sin(2 * p.x) * std::cos(1.5f * p.y)) * std::max(0.0f, glm::dot(out, normal));
  };
  Diagnostics diagnostics;
  for (const char* filterName : {"box", "gaussian"}) {
    const auto filter = plugIns().filters.make(parseParameterText(filterName, ""), {}, diagnostics);
    for (const auto& entry : plugIns().cameras.entries())
      for (const std::string& example : entry.examples) {
        const std::string words = entry.name + " " + example + ", filter " + filterName;
        const auto camera = makeCamera(entry.name, example, Mat4d(1));
        if (!camera->isConnectable()) continue;
        constexpr PixelBounds BOUNDS{2, 1, 8, 6}; // a crop of the film
        Film viewed(BOUNDS, 1), splatted(BOUNDS, 1);
        splatted.enableSplats(0x1p-40);
        constexpr uint32_t SAMPLES = 1 << 10, SPLATS = 1 << 19;
        constexpr float DISTANCE = 2, SIZE = 30;
        const Vec3f middle(0, 0, DISTANCE);
        for (int y = BOUNDS.y0; y < BOUNDS.y1; ++y)
          for (int x = BOUNDS.x0; x < BOUNDS.x1; ++x)
            for (uint32_t i = 0; i < SAMPLES; ++i) {
              const size_t pixel = size_t(y - BOUNDS.y0) * size_t(BOUNDS.width()) + size_t(x - BOUNDS.x0);
              Sampler sampler(1, pixel, i);
              const Filter::Sample f = filter->sample(sampler.next2D());
              const auto ray = camera->sampleRay({Vec2f(x, y) + 0.5f + f.offset, sampler.next2D()});
              const float t = glm::dot(middle - ray->origin, normal) / glm::dot(ray->direction, normal);
              const Rgb value(t > 0 && glm::distance(ray->at(t), middle) < SIZE
                                  ? radiance(ray->at(t), -ray->direction)
                                  : 0.0f);
              viewed.add(pixel, 0, f.weight, &value, value);
            }
        const Frame frame(normal);
        for (uint32_t i = 0; i < SPLATS; ++i) {
          Sampler sampler(2, 0, i);
          // More samples towards the middle: the disc's radius is the square of a number.
          const Vec2f disk = uniformDisk(sampler.next2D());
          const float r2 = glm::dot(disk, disk);
          const Vec3f point = middle + frame.toWorld(Vec3f(disk * r2 * SIZE, 0));
          const float area = 3 * PI * square(SIZE) * square(r2); // 1 / density
          const auto wi = camera->sampleWi(point, sampler.next2D(), 0);
          if (!wi) continue;
          const float cosine = std::max(0.0f, glm::dot(normal, wi->direction));
          splatted.splat(wi->film, *filter, 1,
                         Rgb(radiance(point, wi->direction) * cosine * area * wi->importance / wi->pdf));
        }
        splatted.splats()->addPaths(SPLATS);
        double difference = 0, mean = 0;
        for (size_t i = 0; i < BOUNDS.area(); ++i) {
          mean += double(viewed.value(i, 0).g) / double(BOUNDS.area());
          difference += double(splatted.value(i, 0).g - viewed.value(i, 0).g) / double(BOUNDS.area());
        }
        for (size_t i = 0; i < BOUNDS.area(); ++i) {
          const double a = double(viewed.value(i, 0).g);
          EXPECT_NEAR(a, double(splatted.value(i, 0).g), 0.16 * std::max(a, 0.1 * mean))
              << words << ", pixel " << i;
        }
        EXPECT_GT(mean, 0.1) << words;
        EXPECT_NEAR(difference, 0, 0.01 * mean) << words;
      }
  }
}

TEST(Cameras, TheCircleOfConfusionIsThatOfTheThinLensEquation) {
  constexpr double RADIUS = 0.2, FOCUS = 3, FOCAL_LENGTH = 0.5;
  const auto camera = makeCamera(
      "perspective", "\"float fov\" 30 \"float lensradius\" 0.2 \"float focaldistance\" 3", Mat4d(1));
  // The film is at the image distance of the focus distance; it is HEIGHT pixels high, which gives the field
  // of view.
  const auto imageDistance = [](double z) { return 1 / (1 / FOCAL_LENGTH - 1 / z); };
  const double film = imageDistance(FOCUS), pixel = 2 * film * std::tan(glm::radians(15.0)) / HEIGHT;
  for (const double z : {0.8, 1.5, 3.0, 6.0, 50.0}) {
    const double v = imageDistance(z), diameter = 2 * RADIUS * std::abs(film - v) / v / pixel;
    Bounds3f seen;
    for (uint32_t i = 0; i < 1000; ++i) {
      Sampler sampler(1, 4, i);
      const auto wi = camera->sampleWi(Vec3f(0.1f, 0, z), sampler.next2D(), 0);
      seen.add(Vec3f(wi->film, 0));
    }
    EXPECT_NEAR(seen.diagonal().x, diameter, 0.5) << z;
    EXPECT_NEAR(seen.diagonal().y, diameter, 0.5) << z;
  }
}

TEST(Cameras, BladesMakeAPolygonOfItsArea) {
  // Points on a hexagonal lens, from the origins of rays, against the hexagon's second moment and its
  // borders.
  const auto camera = makeCamera("perspective",
                                 "\"float lensradius\" 2 \"integer apertureblades\" 6 "
                                 "\"float aperturerotation\" 30",
                                 Mat4d(1));
  double moment = 0, widest = 0, highest = 0;
  constexpr uint32_t N = 1 << 14;
  for (uint32_t i = 0; i < N; ++i) {
    Sampler sampler(1, 5, i);
    const Vec3f p = camera->sampleRay({Vec2f(1), sampler.next2D()})->origin;
    moment += double(p.x * p.x) / N;
    widest = std::max(widest, double(p.x));
    highest = std::max(highest, double(p.y));
  }
  const double side = 2;
  EXPECT_NEAR(moment, 5 * std::sqrt(3.0) / 16 * std::pow(side, 4) / (1.5 * std::sqrt(3.0) * side * side),
              5e-3);
  EXPECT_NEAR(widest, side * std::sqrt(0.75), 0.02);
  EXPECT_NEAR(highest, side, 0.1);
}

TEST(Cameras, EvenLightIsSeenEvenly) {
  // The tolerance allows the vignetting of lens systems, whose rays have weights or are blocked.
  forEachCamera([](const Camera& camera, const std::string& words) {
    if (words.rfind("realistic", 0) == 0) return;
    for (uint32_t i = 0; i < 200; ++i) {
      Sampler sampler(1, 6, i);
      const auto ray = camera.sampleRay({sampler.next2D() * Vec2f(WIDTH, HEIGHT), sampler.next2D()});
      ASSERT_TRUE(ray) << words;
      EXPECT_EQ(ray->weight, 1) << words;
      EXPECT_NEAR(glm::length(ray->direction), 1, 1e-6) << words;
    }
  });
}

TEST(Filters, ValuesAreWhatSamplesStandFor) {
  // Moments of weighted samples against moments of the value, on a grid.
  for (const auto& entry : plugIns().filters.entries()) {
    Diagnostics diagnostics;
    const auto filter = plugIns().filters.make(
        parseParameterText(entry.name, "\"float xradius\" 1.7 \"float yradius\" 0.8"), {}, diagnostics);
    const auto weigh = [](const Vec2f& o) { return Vec3d(1, o.x * o.x, std::abs(o.x * o.y)); };
    Vec3d sampled(0), integrated(0);
    constexpr uint32_t N = 1 << 16;
    for (uint32_t i = 0; i < N; ++i) {
      Sampler sampler(1, 1, i);
      const Filter::Sample s = filter->sample(sampler.next2D());
      sampled += weigh(s.offset) * (double(s.weight) / N);
    }
    EXPECT_EQ(filter->radius(), Vec2f(1.7f, 0.8f)) << entry.name;
    constexpr int GRID = 1024;
    constexpr double STEP = 4.0 / GRID;
    for (int y = 0; y < GRID; ++y)
      for (int x = 0; x < GRID; ++x) {
        const Vec2f o((x + 0.5) * STEP - 2, (y + 0.5) * STEP - 2);
        integrated += weigh(o) * (double(filter->value(o)) * STEP * STEP);
      }
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(sampled[i], integrated[i], 4e-3) << entry.name << ", moment " << i;
    EXPECT_NEAR(integrated[0], 1, 4e-3) << entry.name;
  }
}

namespace {

/** Contributions of very different magnitudes, a few of them wide. */
template <class Use> void forEachSplat(const Use& use) {
  for (uint32_t i = 0; i < 20000; ++i) {
    Sampler sampler(3, 0, i);
    const Vec2f film = sampler.next2D() * 20.0f - 2.0f;
    use(i, film, Rgb(std::exp(20 * sampler.next1D() - 10)));
  }
}

} // namespace

TEST(FilmSettings, RenderTheWholeFilmUnlessCropped) {
  const FilmSettings film;
  EXPECT_EQ(film.crop.width(), film.width);
  EXPECT_EQ(film.crop.height(), film.height);
}

TEST(Splats, AreTheSameBitsInAnyOrder) {
  Diagnostics diagnostics;
  const auto filter = plugIns().filters.make(parseParameterText("mitchell", ""), {}, diagnostics);
  constexpr PixelBounds BOUNDS{3, 3, 13, 11};
  SplatPlane forwards(BOUNDS, 2, 0x1p-30), halves[2] = {forwards, forwards};
  std::vector<std::pair<Vec2f, Rgb>> all;
  forEachSplat([&](uint32_t i, const Vec2f& film, const Rgb& value) {
    forwards.add(film, *filter, 1 + i % 3, value);
    all.emplace_back(film, value);
  });
  for (size_t i = all.size(); i-- > 0;)
    halves[i % 7 == 0].add(all[i].first, *filter, 1 + i % 3, all[i].second);
  halves[0].add(halves[1]);
  forwards.addPaths(3);
  halves[0].addPaths(3);
  for (size_t pixel = 0; pixel < BOUNDS.area(); ++pixel)
    for (size_t layer = 0; layer < 2; ++layer) {
      EXPECT_EQ(forwards.value(pixel, layer), halves[0].value(pixel, layer));
      EXPECT_NE(forwards.value(pixel, layer), BLACK);
    }
}

TEST(Splats, BelowTheUnitAreRightInTheMean) {
  Diagnostics diagnostics;
  const auto filter = plugIns().filters.make(parseParameterText("box", ""), {}, diagnostics);
  SplatPlane plane({0, 0, 1, 1}, 1, 1);
  constexpr int N = 100000;
  for (uint32_t i = 0; i < N; ++i) {
    Sampler sampler(4, 0, i);
    plane.add(sampler.next2D(), *filter, 1, {0.003f, 0.3f, 1.25f});
  }
  plane.addPaths(N);
  EXPECT_NEAR(plane.value(0, 0).r, 0.003, 6 * std::sqrt(0.003 / N));
  EXPECT_NEAR(plane.value(0, 0).g, 0.3, 6 * std::sqrt(0.21 / N));
  EXPECT_NEAR(plane.value(0, 0).b, 1.25, 6 * std::sqrt(0.19 / N));
  EXPECT_EQ(plane.saturated(), 0u);
}

TEST(Splats, TooBrightForTheUnitAreCounted) {
  Diagnostics diagnostics;
  const auto filter = plugIns().filters.make(parseParameterText("box", ""), {}, diagnostics);
  SplatPlane plane({0, 0, 1, 1}, 1, 0x1p-30);
  plane.add(Vec2f(0.5f), *filter, 1, {1e20f, 0, 0});
  EXPECT_EQ(plane.saturated(), 1u);
  for (int i = 0; i < 1000; ++i)
    plane.add(Vec2f(0.5f), *filter, 1, {0, 0x1p58f, 0}); // the squares of the contributions saturate
  EXPECT_GT(plane.saturated(), 1u);
}

TEST(Splats, LargeSumsKeepSmallContributions) {
  Diagnostics diagnostics;
  const auto filter = plugIns().filters.make(parseParameterText("box", ""), {}, diagnostics);
  SplatPlane plane({0, 0, 1, 1}, 1, 1);
  for (const float sign : {1.0f, -1.0f}) // sums larger than 64 bits, with 3 in between
    for (int i = 0; i < 4; ++i) {
      plane.add(Vec2f(0.5f), *filter, 1, {sign * 0x1p70f, sign, sign * 0x1p62f});
      plane.add(Vec2f(0.5f), *filter, 1, {3, -3, 0});
    }
  plane.addPaths(2);
  EXPECT_EQ(plane.value(0, 0), Rgb(12, -12, 0));
  EXPECT_EQ(plane.saturated(), 0u);
}
