/** @file
 * Light from pictures: layouts, integrals, densities, portals, photometric files, the sky, and messages about
 * bad files.
 */
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <random>

#include <unistd.h>

#include "lights/environment/portal.h"
#include "lights/maps/environmentMap.h"
#include "lights/pattern/iesProfile.h"
#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"

using namespace recurse;

namespace {

using std::numbers::pi;

Vec3d anyDirection(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit;
  const double z = 2 * unit(random) - 1, phi = 2 * pi * unit(random), r = std::sqrt(1 - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

Image pictureOf(int width, int height, const std::function<Rgb(double, double)>& value) {
  Image image(width, height, {"R", "G", "B"});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Rgb v = value((x + 0.5) / width, (y + 0.5) / height);
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = v[c];
    }
  return image;
}

/** Noise with black regions, and a sun of one pixel. */
Image sunnyNoise(int width, int height) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<float> unit;
  Image image = pictureOf(width, height, [&](double, double) {
    const float v = unit(random);
    return v < 0.3f ? BLACK : Rgb(v, v * v, 0.5f);
  });
  std::fill_n(image.at(width / 3, height / 4), 3, 3e4f);
  return image;
}

/** File that the destructor deletes. */
class PictureFile {
 public:
  explicit PictureFile(const Image& image, const std::string& name = "light.pfm")
      : path((std::filesystem::temp_directory_path() / ("recurse-" + std::to_string(::getpid()) + "-" + name))
                 .string()) {
    writeImage(path, image);
  }
  ~PictureFile() { std::filesystem::remove(path); }
  std::string parameter() const { return "\"string filename\" \"" + path + "\" "; }

 private:
  std::string path;
};

struct MadeLight {
  std::unique_ptr<Light> light;
  std::string told;
};
MadeLight makeLight(const std::string& type, const std::string& parameters,
                    const LightContext& context = {}) {
  Diagnostics diagnostics;
  auto light = plugIns().lights.make(parseParameterText(type, parameters), context, diagnostics);
  if (light) light->prepare({Vec3f(0), 1});
  return {std::move(light), diagnostics.format()};
}
const EnvironmentLight& environment(const MadeLight& made) {
  return dynamic_cast<const EnvironmentLight&>(*made.light);
}

/** Smooth environment without symmetry, whose green integral is 4π. */
Rgb surrounding(const Vec3d& d) {
  return Rgb(1 + 0.5 * d.x, 1 + 0.3 * d.x - 0.2 * d.y + 0.4 * d.z, 1 + 0.6 * d.y * d.z);
}

/** Direction in light space (+z up) for a direction of a viewer who looks along -z with +y up. */
Vec3d fromViewer(const Vec3d& d) { return {d.z, -d.x, d.y}; }

} // namespace

TEST(LightProbes, PlacesOfDirectionsAreThoseOfPbrt) {
  const auto expectPlace = [](EnvironmentMapping mapping, const Vec2d& place, const Vec3d& direction) {
    const Vec3d d = directionOfPlace(mapping, place);
    EXPECT_NEAR(glm::distance(d, direction), 0, 1e-3) << place.x << " " << place.y;
    EXPECT_NEAR(glm::distance(placeOfDirection(mapping, d), place), 0, 1e-9) << place.x << " " << place.y;
  };
  const auto square = EnvironmentMapping::EQUAL_AREA, around = EnvironmentMapping::LATITUDE_LONGITUDE;
  expectPlace(square, {0.5, 0.5}, {0, 0, 1});
  expectPlace(square, {1, 0.5}, {1, 0, 0});
  expectPlace(square, {0.5, 1}, {0, 1, 0});
  expectPlace(square, {0.75, 0.5}, {0.6614, 0, 0.75});
  expectPlace(square, {0.75, 0.75}, {0.7071, 0.7071, 0});
  EXPECT_NEAR(directionOfPlace(square, {0, 1}).z, -1, 1e-12);
  expectPlace(around, {0.25, 0.5}, {0, 1, 0});
  expectPlace(around, {0.5, 0.25}, {-0.7071, 0, 0.7071});
  std::mt19937_64 random(1);
  for (int i = 0; i < 10000; ++i)
    for (const EnvironmentMapping m : {square, around}) {
      const Vec3d d = anyDirection(random);
      ASSERT_NEAR(glm::distance(directionOfPlace(m, placeOfDirection(m, d)), d), 0, 1e-7);
    }
}

TEST(LightProbes, IntegralOfALightIsThatOfItsPicture) {
  for (const EnvironmentMapping m :
       {EnvironmentMapping::EQUAL_AREA, EnvironmentMapping::LATITUDE_LONGITUDE}) {
    const bool square = m == EnvironmentMapping::EQUAL_AREA;
    const int width = square ? 128 : 512, height = square ? 128 : 256;
    const Image image = sunnyNoise(width, height);
    Rgbd expected(0);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        expected += Rgbd(image.rgb(x, y)) *
                    (square ? 4 * pi / (double(width) * height)
                            : 2 * pi / width * (std::cos(pi * y / height) - std::cos(pi * (y + 1) / height)));
    const EnvironmentMap map(image, m);
    EXPECT_NEAR(map.integral().g / expected.g, 1, 1e-4);
    // Samples of the light have the same integral.
    Rgbd sum(0);
    constexpr int N = 200000;
    std::mt19937_64 random(3);
    std::uniform_real_distribution<float> unit;
    for (int i = 0; i < N; ++i) {
      const float u = unit(random);
      const auto s = map.sample({u, unit(random)}, EnvironmentMap::Sampling::COMPLETE);
      sum += Rgbd(map.value(s.direction)) / (s.pdf * N);
    }
    EXPECT_NEAR(sum.g / map.integral().g, 1, 2e-3);
  }
}

TEST(LightProbes, DensityIsInProportionToLuminanceAndNowhereZeroWhereThereIsLight) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<float> unit;
  for (const EnvironmentMapping m :
       {EnvironmentMapping::EQUAL_AREA, EnvironmentMapping::LATITUDE_LONGITUDE}) {
    const EnvironmentMap map(m == EnvironmentMapping::EQUAL_AREA ? sunnyNoise(64, 64) : sunnyNoise(128, 64),
                             m);
    const double whole = double(luminance(Rgb(map.integral())));
    for (int i = 0; i < 20000; ++i) {
      const Vec3d d = anyDirection(random);
      if (luminance(map.value(d)) > 0) {
        ASSERT_GT(map.pdf(d, EnvironmentMap::Sampling::COMPLETE), 0);
      }
      const float u = unit(random);
      const auto s = map.sample({u, unit(random)}, EnvironmentMap::Sampling::COMPLETE);
      ASSERT_NEAR(s.pdf * whole / double(luminance(map.value(s.direction))), 1, 0.1);
      ASSERT_NEAR(map.pdf(s.direction, EnvironmentMap::Sampling::COMPLETE) / s.pdf, 1, 1e-6);
    }
  }
}

TEST(LightProbes, NumbersAtTheEdgesGiveDirectionsToo) {
  constexpr float EDGES[] = {0, 0.5f, ONE_MINUS_EPSILON};
  for (const int size : {1, 2, 5})
    for (const EnvironmentMapping m :
         {EnvironmentMapping::EQUAL_AREA, EnvironmentMapping::LATITUDE_LONGITUDE}) {
      const EnvironmentMap map(
          pictureOf(size, size, [](double u, double) { return Rgb(static_cast<float>(u)); }), m);
      for (const float x : EDGES)
        for (const float y : EDGES) {
          const auto s = map.sample({x, y}, EnvironmentMap::Sampling::COMPLETE);
          ASSERT_NEAR(glm::length(s.direction), 1, 1e-9) << size << " " << x << " " << y;
          ASSERT_TRUE(std::isfinite(s.pdf));
          ASSERT_TRUE(isFinite(map.value(s.direction)));
        }
    }
}

TEST(LightProbes, CompensatedSamplingTogetherWithUniformSamplingFindsTheSameLight) {
  const EnvironmentMap map(sunnyNoise(64, 64), EnvironmentMapping::EQUAL_AREA);
  std::mt19937_64 random(6);
  std::uniform_real_distribution<float> unit;
  constexpr int N = 200000;
  double sum = 0;
  size_t none = 0;
  for (int i = 0; i < N; ++i) {
    const auto add = [&](const Vec3d& d) { // the balance heuristic
      sum += double(map.value(d).g) / (map.pdf(d, EnvironmentMap::Sampling::COMPENSATED) + 1 / (4 * pi)) / N;
    };
    const float u = unit(random);
    add(map.sample({u, unit(random)}, EnvironmentMap::Sampling::COMPENSATED).direction);
    const Vec3d d = anyDirection(random);
    add(d);
    none += map.pdf(d, EnvironmentMap::Sampling::COMPENSATED) == 0;
  }
  EXPECT_NEAR(sum / map.integral().g, 1, 5e-3);
  EXPECT_GT(none, N / 10); // the alternative technique is needed
}

TEST(LightProbes, EveryLayoutShowsTheSameSurrounding) {
  const auto expectSurrounding = [](const std::string& layout, const Image& image, double tolerance,
                                    bool guessed) {
    const PictureFile file(image, "sky_probe.pfm");
    const MadeLight made =
        makeLight("infinite", file.parameter() + (guessed ? "" : "\"string mapping\" \"" + layout + "\""));
    ASSERT_TRUE(made.light) << made.told;
    EXPECT_EQ(made.told.find("\"" + layout + "\"") != std::string::npos, guessed) << made.told;
    std::mt19937_64 random(7);
    for (int i = 0; i < 5000; ++i) {
      const Vec3d d = anyDirection(random);
      const Rgb seen = environment(made).radiance(Vec3f(d)), expected = surrounding(d);
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(seen[c], expected[c], tolerance) << layout << " " << d.x << " " << d.y;
    }
    EXPECT_NEAR(double(made.light->power().g) / (4 * pi * pi), 1, 1e-3) << layout;
  };
  constexpr int N = 128;
  const auto square = [](double u, double v) {
    return surrounding(directionOfPlace(EnvironmentMapping::EQUAL_AREA, {u, v}));
  };
  expectSurrounding("equalarea", pictureOf(N, N, square), 0.02, false);
  expectSurrounding("latlong",
                    pictureOf(2 * N, N,
                              [](double u, double v) {
                                const double phi = 2 * pi * u, theta = pi * v;
                                return surrounding({std::sin(theta) * std::cos(phi),
                                                    std::sin(theta) * std::sin(phi), std::cos(theta)});
                              }),
                    0.02, true);
  const auto round = [](const auto& direction) {
    return [direction](double u, double v) {
      const double x = 2 * u - 1, y = 1 - 2 * v, r = std::hypot(x, y);
      return r > 1 ? BLACK : surrounding(fromViewer(direction(x, y, r)));
    };
  };
  expectSurrounding("angular", pictureOf(N, N, round([](double x, double y, double r) {
                                           const double theta = pi * r;
                                           return Vec3d(std::sin(theta) * x / r, std::sin(theta) * y / r,
                                                        -std::cos(theta));
                                         })),
                    0.05, true);
  // Near the rim of a mirror ball a pixel covers a wide range of directions.
  expectSurrounding("mirrorball", pictureOf(4 * N, 4 * N, round([](double x, double y, double r) {
                                              const double z = std::sqrt(1 - r * r);
                                              return Vec3d(2 * x * z, 2 * y * z, 2 * z * z - 1);
                                            })),
                    0.15, false);
  const auto cross = [](bool vertical) {
    return [vertical](double u, double v) {
      const double across = u * (vertical ? 3 : 4), down = v * (vertical ? 4 : 3);
      const int column = static_cast<int>(across), row = static_cast<int>(down);
      const double s = 2 * (across - column) - 1, t = 1 - 2 * (down - row);
      Vec3d d(0);
      if (row == 1 && column == 0) d = {-1, t, -s};
      if (row == 1 && column == 1) d = {s, t, -1};
      if (row == 1 && column == 2) d = {1, t, s};
      if (row == 1 && column == 3) d = {-s, t, 1};
      if (row == 0 && column == 1) d = {s, 1, t};
      if (row == 2 && column == 1) d = {s, -1, -t};
      if (row == 3 && column == 1) d = {s, -t, 1};
      return d == Vec3d(0) ? BLACK : surrounding(fromViewer(glm::normalize(d)));
    };
  };
  expectSurrounding("verticalcross", pictureOf(3 * N, 4 * N, cross(true)), 0.03, true);
  expectSurrounding("horizontalcross", pictureOf(4 * N, 3 * N, cross(false)), 0.03, true);
}

TEST(LightProbes, IlluminanceIsTwiceOfWhatIsWishedAsInPbrt) {
  const PictureFile file(pictureOf(64, 64, [](double, double) { return Rgb(3); }));
  const MadeLight made = makeLight("infinite", file.parameter() + "\"float illuminance\" 10");
  ASSERT_TRUE(made.light) << made.told;
  EXPECT_NEAR(environment(made).radiance({0, 0, 1}).g * PI, 20, 0.05);
}

TEST(LightProbes, TransformsTurnThePicture) {
  const PictureFile file(pictureOf(64, 64, [](double u, double v) {
    return surrounding(directionOfPlace(EnvironmentMapping::EQUAL_AREA, {u, v}));
  }));
  Mat4d turned(1); // light space +z is the scene's +y, and the picture is mirrored
  turned[0] = {-1, 0, 0, 0};
  turned[1] = {0, 0, 1, 0};
  turned[2] = {0, 1, 0, 0};
  const MadeLight made = makeLight("infinite", file.parameter(), {turned});
  ASSERT_TRUE(made.light) << made.told;
  for (const Vec3d& d : {Vec3d(0, 1, 0), Vec3d(0.6, 0, 0.8), Vec3d(-0.48, 0.6, 0.64)})
    EXPECT_NEAR(environment(made).radiance(Vec3f(d)).g, surrounding({-d.x, d.z, d.y}).g, 0.02);
}

/** Irradiance beside a window under a uniform sky of radiance 1. */
TEST(Portals, UniformSkyThroughAWindowHasTheIrradianceOfItsFormFactor) {
  // A horizontal window with one corner above the point; p1 - p0 and p3 - p0 make the normal point up.
  constexpr double A = 1.5, B = 0.75, H = 1.25;
  const MadeLight made = makeLight(
      "infinite", "\"rgb L\" [1 1 1] \"point3 portal\" [0 0 1.25  0 .75 1.25  1.5 .75 1.25  1.5 0 1.25]");
  ASSERT_TRUE(made.light) << made.told;
  const double x = A / H, y = B / H, sx = std::sqrt(1 + x * x), sy = std::sqrt(1 + y * y);
  const double expected = (x / sx * std::atan(y / sx) + y / sy * std::atan(x / sy)) / 2;
  double sum = 0;
  constexpr uint32_t N = 100000;
  for (uint32_t i = 0; i < N; ++i) {
    Sampler sampler(1, 1, i);
    const float pick = sampler.next1D();
    const auto s = made.light->sampleLi(Vec3f(0), pick, sampler.next2D());
    ASSERT_TRUE(s);
    const Vec3f at = s->direction * static_cast<float>(H / double(s->direction.z));
    const bool through = s->direction.z > 0 && at.x > 0 && at.y > 0 && at.x < A && at.y < B;
    ASSERT_NEAR(environment(made).pdfLi(Vec3f(0), s->direction) / s->pdf, 1, 1e-3);
    if (through) sum += double(s->radiance.g * s->direction.z / s->pdf) / N;
  }
  EXPECT_NEAR(sum, expected, 0.01 * expected);
}

TEST(Portals, PhotonsGoThroughThePortal) {
  const MadeLight made =
      makeLight("infinite", "\"rgb L\" [1 1 1] \"point3 portal\" [0 0 .5  0 .05 .5  .1 .05 .5  .1 0 .5]");
  ASSERT_TRUE(made.light) << made.told;
  int through = 0;
  double flux = 0;
  constexpr uint32_t N = 50000;
  for (uint32_t i = 0; i < N; ++i) {
    Sampler sampler(1, 1, i);
    const float pick = sampler.next1D();
    const Vec2f place = sampler.next2D();
    const auto s = made.light->sampleLe({pick, place, sampler.next2D()});
    ASSERT_TRUE(s);
    const Vec3f at = s->origin + s->direction * ((0.5f - s->origin.z) / s->direction.z);
    if (!(s->direction.z < 0 && at.x > 0 && at.y > 0 && at.x < 0.1f && at.y < 0.05f)) continue;
    ++through;
    flux += double(s->flux.g) / N;
  }
  EXPECT_GT(through, N * 2 / 5); // half of the photons go upwards
  EXPECT_NEAR(flux / (pi * 0.1 * 0.05), 1, 0.02);
}

TEST(Portals, ThatAreNoRectanglesAreRefused) {
  const MadeLight made =
      makeLight("infinite", "\"rgb L\" [1 1 1] \"point3 portal\" [0 0 1  0 1 1  1 1 1  1 .2 1]");
  EXPECT_FALSE(made.light);
  EXPECT_NE(made.told.find("no rectangle"), std::string::npos) << made.told;
}

TEST(LightPictures, BadOnesAreToldOf) {
  const auto uniform = [](int width, int height) {
    return pictureOf(width, height, [](double, double) { return Rgb(1); });
  };
  const auto expectTold = [](const Image& image, bool renders, const std::string& wanted,
                             const std::string& more = "") {
    const PictureFile file(image);
    const MadeLight made = makeLight("infinite", file.parameter() + more);
    EXPECT_EQ(made.light != nullptr, renders) << made.told;
    EXPECT_NE(made.told.find(wanted), std::string::npos) << made.told;
    if (made.light) {
      EXPECT_TRUE(isFinite(made.light->power()));
      for (uint32_t i = 0; i < 100; ++i) {
        Sampler sampler(1, 1, i);
        const float pick = sampler.next1D();
        const Vec2f place = sampler.next2D();
        if (const auto s = made.light->sampleLe({pick, place, sampler.next2D()})) {
          ASSERT_TRUE(isFinite(s->flux));
        }
      }
    }
  };
  expectTold(uniform(1, 1), true, "");
  Image image = uniform(8, 8);
  image.at(3, 2)[1] = std::numeric_limits<float>::quiet_NaN();
  expectTold(image, false, "pixel 3, 2 (from the top left) is no number");
  image.at(3, 2)[1] = INFINITE;
  expectTold(image, false, "is infinite");
  image.at(3, 2)[1] = -1;
  expectTold(image, true, "1 value is negative");
  image.at(3, 2)[1] = 1e30f;
  expectTold(image, true, "");
  expectTold(pictureOf(8, 8, [](double, double) { return BLACK; }), true, "black everywhere");
  expectTold(pictureOf(8, 8, [](double, double) { return BLACK; }), false, "has no irradiance to scale",
             "\"float illuminance\" 3");
  expectTold(uniform(50, 30), false, "50 by 30 pixels");
  expectTold(uniform(50, 30), true, "", "\"string mapping\" \"latlong\"");
  expectTold(uniform(50, 30), false, "cannot be \"angular\"", "\"string mapping\" \"angular\"");
  expectTold(uniform(8, 8), false, "both a picture and \"L\" are given", "\"rgb L\" [1 1 1]");
  EXPECT_NE(makeLight("infinite", "\"string filename\" \"no-such.hdr\"").told.find("no-such.hdr"),
            std::string::npos);
}

TEST(IesProfiles, AreReadAndFolded) {
  const std::string head = "IESNA:LM-63-1995\n[TEST] x\nTILT=NONE\n1 1000 2 ";
  // A downward cosine lobe of 100 cd, in a file with the multiplier 2.
  std::string angles, values;
  for (int a = 0; a <= 90; a += 5) {
    angles += std::to_string(a) + (a % 20 ? " " : ",\n");
    values += std::to_string(50 * std::cos(a * pi / 180)) + " ";
  }
  const IesProfile lobe = IesProfile::parse(head + "19 1 1 2 0 0 0\n1 1 20\n" + angles + "\n0\n" + values);
  EXPECT_NEAR(lobe.intensity(60, 123), 50, 1e-3);
  EXPECT_EQ(lobe.intensity(91, 0), 0);
  EXPECT_NEAR(lobe.flux() / (100 * pi), 1, 2e-3); // interpolated linearly between 5 degrees
  const auto symmetric = [&](const std::string& horizontal, size_t count) {
    std::string v;
    for (size_t i = 0; i < count; ++i)
      v += " " + std::to_string(10 * (i + 1)) + " " + std::to_string(10 * (i + 1));
    return IesProfile::parse(head + "2 " + std::to_string(count) + " 1 2 0 0 0\n1 1 20\n0 180\n" +
                             horizontal + v);
  };
  const IesProfile quarter = symmetric("0 45 90", 3), half = symmetric("0 90 180", 3),
                   side = symmetric("90 180 270", 3);
  for (const auto& [angle, inQuarter, inHalf, inSide] :
       {std::array{45.0, 40.0, 30.0, 30.0},
        {135.0, 40.0, 50.0, 30.0},
        {200.0, 20 + 20 * 20 / 45.0, 40 + 20 * 70 / 90.0, 40 + 20 * 20 / 90.0},
        {300.0, 20 + 20 * 60 / 45.0, 20 + 20 * 60 / 90.0, 60 - 20 * 30 / 90.0}}) {
    EXPECT_NEAR(quarter.intensity(30, angle), inQuarter, 1e-9) << angle;
    EXPECT_NEAR(half.intensity(30, angle), inHalf, 1e-9) << angle;
    EXPECT_NEAR(side.intensity(30, angle), inSide, 1e-9) << angle;
  }
  const auto expectRefused = [](const std::string& text, const std::string& wanted) {
    try {
      IesProfile::parse(text);
      ADD_FAILURE() << wanted;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(wanted), std::string::npos) << e.what();
    }
  };
  expectRefused("something else\n", "no IES file");
  expectRefused(head + "2 1 1 2 0 0 0\n1 1 20\n0 180\n0\n5 x\n", "line 8");
  expectRefused(head + "2 1 3 2 0 0 0\n1 1 20\n0 180\n0\n5 5\n", "type A");
  expectRefused(head + "2 1 1 2 0 0 0\n1 1 20\n0 180\n0\n5\n", "ends before");
  expectRefused(head + "2 1 1 2 0 0 0\n1 1 20\n180 0\n0\n5 5\n", "vertical angles");
}

TEST(IesProfiles, LightsShineDownAlongMinusY) {
  const MadeLight made = makeLight("goniometric", "\"string profile\" \"scenes/textures/downlight.ies\"");
  ASSERT_TRUE(made.light) << made.told;
  const auto intensity = [&](const Vec3f& d) { // radiant intensity from the irradiance at a distance of 1
    const auto s = made.light->sampleLi(d, 0.5f, Vec2f(0.5f));
    return s ? s->radiance.g : 0;
  };
  EXPECT_NEAR(intensity({0, -1, 0}), 1800, 20);
  EXPECT_EQ(intensity({0, 1, 0}), 0);
  const float angle = 30 * PI / 180;
  EXPECT_NEAR(intensity({std::sin(angle), -std::cos(angle), 0}), 210, 4);
  EXPECT_NEAR(intensity({0, -std::cos(angle), -std::sin(angle)}), 340, 6);
}

TEST(Projections, ShowTheUpperLeftOfThePictureToTheUpperLeft) {
  Image image(2, 2, {"R", "G", "B"});
  image.pixels = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1}; // red, green; blue, white
  const PictureFile file(image);
  const MadeLight made = makeLight("projection", file.parameter() + "\"float fov\" 60");
  ASSERT_TRUE(made.light) << made.told;
  const auto seen = [&](float x, float y) {
    const auto s = made.light->sampleLi(glm::normalize(Vec3f(x, y, 1)), 0.5f, Vec2f(0.5f));
    return s ? s->radiance : BLACK;
  };
  EXPECT_NEAR(maxComponent(abs(seen(-0.3f, 0.3f) - Rgb(1, 0, 0))), 0, 1e-5);
  EXPECT_NEAR(maxComponent(abs(seen(0.5f, 0.5f) - Rgb(0, 1, 0))), 0, 1e-5);
  EXPECT_NEAR(maxComponent(abs(seen(-0.5f, -0.1f) - Rgb(0, 0, 1))), 0, 1e-5);
  EXPECT_EQ(seen(0.6f, 0), BLACK); // outside of 30 degrees
}

TEST(Skies, AreSmoothAlongTheHorizon) {
  const MadeLight made =
      makeLight("sky", "\"float elevation\" 20 \"float azimuth\" 200 \"rgb ground\" [ 0 0 0 ]");
  ASSERT_TRUE(made.light) << made.told;
  constexpr int STEPS = 2000;
  const auto seen = [&](int i, float z) {
    const float azimuth = 2 * PI * float(i) / STEPS;
    const Vec3f d(std::cos(azimuth), std::sin(azimuth), z);
    return luminance(environment(made).radiance(glm::normalize(d)));
  };
  for (int i = 0; i < STEPS; ++i) {
    EXPECT_NEAR(seen(i + 1, 0.0005f) / seen(i, 0.0005f), 1, 0.02) << i;
    EXPECT_EQ(seen(i, -0.04f), 0) << i;
  }
}

TEST(Skies, AreAsBrightAsMeasuredOnes) {
  // On clear days the illuminance of the ground by the sky is 10 to 20 klx, and the model is known to be
  // brighter; a surface that faces the sun has 70 to 100 klx.
  const MadeLight made =
      makeLight("sky", "\"float elevation\" 45 \"float azimuth\" 90 \"float turbidity\" 3");
  ASSERT_TRUE(made.light) << made.told;
  double sky = 0, sun = 0;
  constexpr uint32_t N = 100000;
  for (uint32_t i = 0; i < N; ++i) {
    Sampler sampler(1, 1, i);
    const float pick = sampler.next1D();
    const auto s = made.light->sampleLe({pick, Vec2f(0.5f), sampler.next2D()});
    ASSERT_TRUE(s);
    if (s->direction.z >= 0) continue;
    // East is +y: within the disc of the sun its radiance is thousands of times the sky's.
    const bool disc = glm::dot(-s->direction, glm::normalize(Vec3f(0, 1, 1))) > std::cos(0.005f);
    (disc ? sun : sky) +=
        double(luminance(s->radiance)) * double(disc ? 1 : -s->direction.z) / double(s->pdfDirection) / N;
  }
  EXPECT_GT(sky, 8);
  EXPECT_LT(sky, 40);
  EXPECT_GT(sun, 60);
  EXPECT_LT(sun, 105);
  // The sky is bluer than the sun.
  const Rgb zenith = environment(made).radiance({0, 0, 1});
  EXPECT_GT(zenith.b, 1.5f * zenith.r);
}

TEST(Skies, SunStandsWhereTheCalendarSays) {
  const auto brightest = [](const std::string& when) {
    const MadeLight made = makeLight("sky", when + " \"float turbidity\" 2");
    EXPECT_TRUE(made.light) << made.told;
    Rgb most = BLACK;
    Vec3f towards(0);
    for (uint32_t i = 0; made.light && i < 2000; ++i) {
      Sampler sampler(1, 1, i);
      const float pick = sampler.next1D();
      const auto s = made.light->sampleLe({pick, Vec2f(0.5f), sampler.next2D()});
      if (s && luminance(s->radiance) > luminance(most)) most = s->radiance, towards = -s->direction;
    }
    return towards;
  };
  // At the equinox at noon the sun is overhead on the equator; in Berlin it is 90 - 52.5 degrees high in the
  // south, and in the east in the morning. The equation of time is at most half an hour.
  EXPECT_GT(brightest("\"integer day\" 80").z, 0.99f);
  const Vec3f noon =
      brightest("\"float latitude\" 52.5 \"float longitude\" 15 \"float timezone\" 1 \"integer day\" 80");
  EXPECT_NEAR(std::asin(noon.z) * 180 / PI, 37.5, 1.5);
  EXPECT_LT(noon.x, -0.75f);
  EXPECT_GT(brightest("\"float latitude\" 52.5 \"float longitude\" 15 \"float timezone\" 1 \"integer day\" "
                      "80 \"float hour\" 8")
                .y,
            0.8f);
  const MadeLight night = makeLight("sky", "\"integer day\" 80 \"float hour\" 1");
  EXPECT_FALSE(night.light);
  EXPECT_NE(night.told.find("above the horizon"), std::string::npos) << night.told;
}
