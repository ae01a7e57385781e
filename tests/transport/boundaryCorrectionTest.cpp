/** @file
 * Density estimates where the surface covers only part of the search disc: uniform irradiance must be correct
 * at edges, in corners, beside walls and on curved surfaces.
 */
#include <random>

#include "kernelTesting.h"
#include "rendering.h"
#include "transport/density/gather.h"
#include "transport/density/radiusCache.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

constexpr double IRRADIANCE = 3, ALBEDO = 0.5;

std::string quad(const std::string& corners) {
  return "Shape \"trianglemesh\" \"integer indices\" [ 0 1 2  0 2 3 ] \"point3 P\" [ " + corners + " ]\n";
}
const std::string FLOOR = quad("-1 -1 0  1 -1 0  1 1 0  -1 1 0"),
                  WALL = quad(".5 -1 -1  .5 1 -1  .5 1 1  .5 -1 1");

std::unique_ptr<Scene> sceneOf(const std::string& shapes) {
  // Positions are relative to the scene's centre, which is the origin for all these scenes.
  return sceneFrom(view(64, "0 0 3  0 0 0  0 1 0", 40) + "Material \"diffuse\"\n" + shapes);
}

GatherSettings nearestWithin(int nearest, float radius) {
  GatherSettings search;
  search.nearest = nearest;
  search.radius = radius;
  return search;
}

/** Photons at random points of the floor, with flux that gives IRRADIANCE. */
std::vector<Photon> onFloor(uint64_t seed, int count) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> place(-1, 1);
  std::vector<Photon> list(static_cast<size_t>(count));
  for (Photon& p : list) {
    p.position = {place(random), place(random), 0};
    p.direction = packDirection(glm::normalize(Vec3f(place(random), place(random), 1)));
    p.normal = packDirection({0, 0, 1});
    p.power = Rgb(static_cast<float>(IRRADIANCE * 4 / count));
  }
  return list;
}

/** Neighbourhood of the ray's hit. */
Neighbourhood around(const Scene& scene, const Ray& ray, float radius) {
  Hit hit;
  EXPECT_TRUE(scene.intersect(ray, hit));
  GatherRegion region;
  region.center = hit.point.position;
  region.normal = hit.point.geometricNormal;
  region.radius = radius;
  TransportCounts counts;
  Sampler sampler(3, 0, 0);
  return probeNeighbourhood(scene, glm::length(hit.point.error), region, sampler, counts);
}

/** Ratio of the estimate at the ray's hit to the true value, as a mean over maps. `known`: use the
 * neighbourhood of a point nearby. */
Mean estimateOverTruth(const Scene& scene, const Ray& ray, const GatherSettings& settings, int maps,
                       const std::function<std::vector<Photon>(uint64_t)>& photons, bool known = false) {
  Hit hit;
  EXPECT_TRUE(scene.intersect(ray, hit));
  const Vec3f step(-0.02f, -0.01f, 0);
  const Neighbourhood seen =
      known ? around(scene, {ray.origin + step, ray.direction}, 2 * settings.radius) : Neighbourhood();
  BsdfArena arena;
  const ScatteringPoint scattering(*hit.material->bsdfAt(hit.point, arena), hit.point);
  const PathClasses classes;
  std::vector<double> ratios;
  for (int m = 0; m < maps; ++m) {
    PhotonMap map;
    map.build(photons(static_cast<uint64_t>(m)));
    TransportCounts counts;
    PathRadiance out(classes, counts);
    BoundaryCorrection boundary{scene, Sampler(5, 0, static_cast<uint32_t>(m))};
    if (known) {
      boundary.known = &seen;
      boundary.away = glm::length(step);
    }
    gather(map, settings, scattering, hit.point, -ray.direction, 0, Rgb(1),
           classes.step(classes.cameraStart(), PathEvent::D), out, &boundary);
    ratios.push_back(double(out.total().g) / (ALBEDO * IRRADIANCE / M_PI));
  }
  return Mean(ratios);
}

Ray down(float x, float y) { return {{x, y, 0.5f}, {0, 0, -1}}; }

} // namespace

TEST(BoundaryCorrection, UniformIrradianceAtTheEdgeOfASurface) {
  const auto scene = sceneOf(FLOOR);
  for (const Kernel kernel : ALL_KERNELS)
    for (const auto& [nearest, radius] : std::vector<std::pair<int, float>>{{0, 0.2f}, {100, 1.0f}})
      for (const Vec2f& place : {Vec2f(0, 0), Vec2f(0.3f, 0.9f), Vec2f(-0.99f, 0.2f), Vec2f(0.98f, -0.97f)}) {
        GatherSettings settings;
        settings.kernel = kernel;
        settings.nearest = nearest;
        settings.radius = radius;
        const Mean m = estimateOverTruth(*scene, down(place.x, place.y), settings, samples(100),
                                         [](uint64_t seed) { return onFloor(seed, 4000); });
        // The fraction of the kernel has a random error of .1, so its inverse has a bias of up to (.1/.25)²
        // at the very corner.
        const double bound = std::abs(place.x * place.y) > 0.9f ? 0.06 : 0.015;
        EXPECT_NEAR(m.value, 1, bound + 4 * m.error)
            << kernelName(kernel) << " nearest " << nearest << " at " << place.x << " " << place.y;
      }
}

TEST(BoundaryCorrection, ConcaveCornersAndWhatLiesBehindThem) {
  // The floor continues behind the wall, which has a hundred times the light of the floor, on its front and
  // behind it.
  const auto scene = sceneOf(FLOOR + WALL);
  const auto photons = [](uint64_t seed) {
    std::vector<Photon> list = onFloor(seed, 4000);
    for (Photon& p : list)
      if (p.position.x > 0.5f) p.power *= 100;
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<float> place(-1, 1);
    for (int i = 0; i < 2000; ++i) {
      Photon p;
      p.position = {0.5f, place(random), (place(random) + 1) / 2};
      p.direction = packDirection(glm::normalize(Vec3f(-1, place(random), place(random))));
      p.normal = packDirection({-1, 0, 0});
      p.power = Rgb(float(100 * IRRADIANCE * 2 / 2000));
      list.push_back(p);
    }
    return list;
  };
  for (const auto& [nearest, radius] : std::vector<std::pair<int, float>>{{0, 0.2f}, {50, 1.0f}})
    for (const float x : {0.1f, 0.4f, 0.49f}) {
      GatherSettings settings;
      settings.nearest = nearest;
      settings.radius = radius;
      const Mean m = estimateOverTruth(*scene, down(x, 0.1f), settings, samples(100), photons);
      EXPECT_NEAR(m.value, 1, 0.015 + 4 * m.error) << "nearest " << nearest << " at " << x;
    }
}

TEST(BoundaryCorrection, StripsMuchNarrowerThanTheSearch) {
  const auto scene = sceneOf(quad("-.02 -1 0  .02 -1 0  .02 1 0  -.02 1 0"));
  const auto photons = [](uint64_t seed) {
    std::vector<Photon> list = onFloor(seed, 4000);
    for (Photon& p : list) {
      p.position.x *= 0.02f;
      p.power *= 0.02f;
    }
    return list;
  };
  GatherSettings settings;
  settings.radius = 1;
  const Mean m = estimateOverTruth(*scene, down(0.01f, 0.1f), settings, samples(100), photons, true);
  EXPECT_NEAR(m.value, 1, 0.03 + 4 * m.error);
}

TEST(BoundaryCorrection, BesideALowBoardThatLiesOnTheFloor) {
  const auto scene =
      sceneOf(FLOOR + "Shape \"box\" \"point3 p1\" [ .1 -1 .001 ] \"point3 p2\" [ 1 1 .006 ]\n");
  const auto photons = [](uint64_t seed) {
    std::vector<Photon> list = onFloor(seed, 4000);
    for (Photon& p : list)
      if (p.position.x > 0.1f) p.position.z = 0.006f;
    return list;
  };
  for (const float x : {0.0f, 0.05f, 0.09f}) {
    GatherSettings settings;
    settings.radius = 0.4f;
    const Mean m = estimateOverTruth(*scene, down(x, 0.1f), settings, samples(100), photons, true);
    EXPECT_NEAR(m.value, 1, 0.03 + 4 * m.error) << x;
  }
}

TEST(BoundaryCorrection, CurvedSurfaces) {
  const auto scene = sceneOf("Shape \"sphere\" \"float radius\" 1\n");
  const auto photons = [](uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<float> normal;
    std::vector<Photon> list(8000);
    for (Photon& p : list) {
      p.position = glm::normalize(Vec3f(normal(random), normal(random), normal(random)));
      p.direction = p.normal = packDirection(p.position);
      p.power = Rgb(float(IRRADIANCE * 4 * M_PI / double(list.size())));
    }
    return list;
  };
  for (const float radius : {0.05f, 0.2f, 0.5f, 5.0f}) {
    GatherSettings settings;
    settings.radius = radius;
    const Mean m = estimateOverTruth(*scene, {{0.2f, 0.1f, 3}, {0, 0, -1}}, settings, samples(100), photons);
    EXPECT_NEAR(m.value, 1, 0.015 + 4 * m.error) << radius;
  }
}

namespace {

/** A wavy sheet over the square, with waves along x, made of strips that are straight between their edges. */
struct WavySheet {
  double amplitude, z = 0;
  bool smooth = false; ///< vertices have normals
  static constexpr double LENGTH = .1;
  static constexpr int STRIPS_PER_WAVE = 16;

  static double step() { return LENGTH / STRIPS_PER_WAVE; }
  double edge(double i) const { return z + amplitude * std::sin(2 * M_PI * i / STRIPS_PER_WAVE); }
  double at(double x) const {
    const double i = std::floor((x + 1) / step()), part = (x + 1) / step() - i;
    return edge(i) * (1 - part) + edge(i + 1) * part;
  }
  double slope(double x) const {
    const double i = std::floor((x + 1) / step());
    return (edge(i + 1) - edge(i)) / step();
  }
  std::string shape() const {
    std::ostringstream points, normals, indices;
    const int strips = int(std::lround(2 / step()));
    for (int i = 0; i <= strips; ++i)
      for (const int y : {-1, 1}) {
        points << -1 + i * step() << ' ' << y << ' ' << edge(i) << "  ";
        normals << edge(i - 1) - edge(i + 1) << " 0 " << 2 * step() << "  ";
      }
    for (int i = 0; i < strips; ++i)
      indices << 2 * i << ' ' << 2 * i + 2 << ' ' << 2 * i + 3 << "  " << 2 * i << ' ' << 2 * i + 3 << ' '
              << 2 * i + 1 << "  ";
    return "Shape \"trianglemesh\" \"integer indices\" [ " + indices.str() + "] \"point3 P\" [ " +
           points.str() + "]" + (smooth ? " \"normal N\" [ " + normals.str() + "]" : "") + "\n";
  }
  /** Photons from above, near the middle, that give IRRADIANCE. */
  std::vector<Photon> lit(uint64_t seed) const {
    std::vector<Photon> list = onFloor(seed, 4000);
    for (Photon& p : list) {
      p.position *= .4f;
      p.power *= square(.4f);
    }
    for (Photon& p : list) {
      const double x = double(p.position.x), tilt = slope(x);
      const Frame frame(glm::normalize(Vec3f(float(-tilt), 0, 1)));
      p.position.z = float(at(x));
      p.direction = packDirection(frame.toWorld(unpackDirection(p.direction)));
      p.normal = packDirection(frame.z);
      p.power *= float(std::hypot(1, tilt));
    }
    return list;
  }
};

} // namespace

TEST(BoundaryCorrection, SmallWaves) {
  for (const bool smooth : {false, true})
    for (const double amplitude : {.002, .02}) {
      const WavySheet sheet{amplitude, 0, smooth};
      const auto scene = sceneOf(sheet.shape());
      for (const float radius : {.03f, .2f})
        for (const float x : {.003f, .078f}) {
          GatherSettings settings;
          settings.radius = radius;
          const Mean m = estimateOverTruth(*scene, down(x, .1f), settings, samples(40),
                                           [&](uint64_t seed) { return sheet.lit(seed); });
          EXPECT_NEAR(m.value, 1, .03 + 4 * m.error)
              << amplitude << (smooth ? " smooth" : "") << " radius " << radius << " at " << x;
        }
    }
}

TEST(BoundaryCorrection, ThinWrinkledDoubleLayers) {
  for (const double amplitude : {.002, .01}) {
    const WavySheet sheet{amplitude}, lower{amplitude, -.004};
    const auto scene = sceneOf(sheet.shape() + lower.shape());
    GatherSettings settings;
    settings.radius = .2f;
    for (const float x : {.003f, .053f, .078f}) {
      const Mean m = estimateOverTruth(*scene, down(x, .1f), settings, samples(80),
                                       [&](uint64_t seed) { return sheet.lit(seed); });
      EXPECT_NEAR(m.value, 1, .03 + 4 * m.error) << amplitude << " at " << x;
    }
  }
}

TEST(BoundaryCorrection, PhotonsBelowAWaterLineDoNotCountAboveIt) {
  // The wall of a pool is the floor in this test, and the water surface is perpendicular to it.
  const auto scene =
      sceneOf(FLOOR + "Material \"dielectric\" \"float eta\" 1.33\n" + quad("0 -1 0  0 1 0  0 1 1  0 -1 1"));
  const auto photons = [](uint64_t seed) {
    std::vector<Photon> list = onFloor(seed, 4000);
    for (Photon& p : list)
      if (p.position.x > 0) p.power *= 2;
    return list;
  };
  GatherSettings settings;
  settings.radius = .2f;
  for (const bool known : {false, true})
    for (const float x : {-.1f, -.01f, .03f, .1f}) {
      const Mean m = estimateOverTruth(*scene, down(x, .1f), settings, samples(100), photons, known);
      EXPECT_NEAR(m.value, x > 0 ? 2 : 1, .02 + 4 * m.error) << x << (known ? " known" : "");
    }
}

TEST(BoundaryCorrection, ASheetCloseBeforeAWallEndsWhatIsSeenOfTheWall) {
  // The wall is the floor in this test: the sheet hides part of it in a disc of radius .4.
  const auto scene = sceneOf(FLOOR + quad(".1 -1 .02  1 -1 .02  1 1 .02  .1 1 .02"));
  const Neighbourhood beside = around(*scene, down(0, 0), .4f);
  EXPECT_GT(beside.flat, .38f);
  ASSERT_EQ(beside.planeCount, 1u);
  EXPECT_NEAR(beside.planes[0].offset, -.1f, 2e-4f);
  const auto photons = [](uint64_t seed) {
    std::vector<Photon> list = onFloor(seed, 4000);
    for (Photon& p : list)
      if (p.position.x > .1f) p.position.z = .02f;
    return list;
  };
  GatherSettings settings;
  settings.radius = .4f;
  for (const bool known : {false, true})
    for (const float x : {-.1f, 0.0f, .05f}) {
      const Mean m = estimateOverTruth(*scene, down(x, .1f), settings, samples(100), photons, known);
      EXPECT_NEAR(m.value, 1, .02 + 4 * m.error) << x << (known ? " known" : "");
    }
}

TEST(BoundaryCorrection, WhatIsSeenOfWallsAndEdges) {
  const auto scene = sceneOf(FLOOR + WALL);
  for (const float x : {-0.9f, -0.2f, 0.3f, 0.45f}) {
    const Neighbourhood seen = around(*scene, down(x, 0), 0.4f);
    EXPECT_GE(seen.flat, 0.38f) << x;
    EXPECT_TRUE(seen.sees(Vec3f(x, 0, 0)));
    ASSERT_EQ(seen.planeCount, x == -0.2f ? 0u : 1u) << x;
    if (seen.planeCount == 0) continue;
    const BoundaryPlane& plane = seen.planes[0];
    EXPECT_EQ(plane.kind, x > 0 ? BoundaryPlane::WALL : BoundaryPlane::EDGE) << x;
    EXPECT_GT(std::abs(plane.normal.x), 0.9999f) << x;
    EXPECT_NEAR(plane.offset, x > 0 ? -0.5f : -1.0f, 2e-4f) << x;
    EXPECT_FALSE(seen.sees(x > 0 ? Vec3f(0.6f, 0, 0) : Vec3f(-1.1f, 0, 0))) << x;
  }
  EXPECT_EQ(around(*scene, down(-0.2f, 0), 0.1f).planeCount, 0u);
  EXPECT_EQ(around(*scene, down(-0.8f, -0.9f), 0.4f).planeCount, 2u) << "at a corner";
}

TEST(BoundaryCorrection, BentEdgesAndSurfacesAreNoStraightOnes) {
  const auto flat = [](const std::string& shape, float x, float radius) {
    return around(*sceneOf(shape), down(x, 0), radius);
  };
  const Neighbourhood rim = flat("Shape \"disk\" \"float radius\" .3\n", 0.1f, 0.4f);
  EXPECT_EQ(rim.planeCount, 0u);
  EXPECT_LE(rim.flat, 0.2f);
  const std::string ball = "Translate 0 0 -1\nShape \"sphere\" \"float radius\" 1\n";
  EXPECT_EQ(flat(ball, 0.1f, 0.4f).planeCount, 0u);
  EXPECT_LE(flat(ball, 0.1f, 0.4f).flat, 0.05f);
  // The ridge of a roof is an edge, although vertical rays hit the second side as well.
  const Neighbourhood roof =
      flat(quad("-1 -1 0  .2 -1 0  .2 1 0  -1 1 0") + quad(".2 -1 0  1 -1 -.4  1 1 -.4  .2 1 0"), 0, 0.4f);
  ASSERT_EQ(roof.planeCount, 1u);
  EXPECT_NEAR(roof.planes[0].offset, -0.2f, 2e-4f);
  EXPECT_GE(roof.flat, 0.38f);
}

TEST(BoundaryCorrection, KnownEdgesAndWhatLiesJustBelow) {
  // A ledge below the edge, within the height of the search region, has a hundred times the light of the
  // floor.
  const auto scene = sceneOf(FLOOR + quad("1 -1 -.02  2 -1 -.02  2 1 -.02  1 1 -.02"));
  const auto photons = [](uint64_t seed) {
    std::vector<Photon> list = onFloor(seed, 4000);
    for (int i = 0; i < 4000; ++i) {
      Photon p = list[size_t(i)];
      p.position += Vec3f(2, 0, -0.02f);
      p.power *= 100;
      list.push_back(p);
    }
    return list;
  };
  for (const Kernel kernel : ALL_KERNELS)
    for (const auto& [nearest, radius] : std::vector<std::pair<int, float>>{{0, 0.2f}, {50, 1.0f}})
      for (const Vec2f& place :
           {Vec2f(0.3f, 0.2f), Vec2f(0.9f, 0.2f), Vec2f(0.99f, 0.2f), Vec2f(0.98f, 0.97f)}) {
        GatherSettings settings;
        settings.kernel = kernel;
        settings.nearest = nearest;
        settings.radius = radius;
        const Mean m =
            estimateOverTruth(*scene, down(place.x, place.y), settings, samples(100), photons, true);
        EXPECT_NEAR(m.value, 1, 0.005 + 4 * m.error)
            << kernelName(kernel) << " nearest " << nearest << " at " << place.x << " " << place.y;
      }
}

TEST(BoundaryCorrection, NarrowGaps) {
  // A block above the floor: .01 is a narrow gap for a disc of radius .2, .1 is not.
  const auto block = [](double below) {
    const std::string z = std::to_string(below);
    return sceneOf(FLOOR + quad(".5 -1 " + z + "  .5 1 " + z + "  .5 1 1  .5 -1 1") +
                   quad(".5 -1 " + z + "  .5 1 " + z + "  1 1 " + z + "  1 -1 " + z));
  };
  const Ray beside{{.4f, .1f, .005f}, {0, 0, -1}}, under{{.7f, .1f, .005f}, {0, 0, -1}};
  const auto narrow = block(.01), wide = block(.1);
  const Neighbourhood divided = around(*narrow, beside, .2f);
  EXPECT_TRUE(divided.sees({.49f, .1f, 0}));
  EXPECT_FALSE(divided.sees({.51f, .1f, 0}));
  EXPECT_EQ(divided.clearance, INFINITE);
  EXPECT_TRUE(around(*wide, beside, .2f).sees({.51f, .1f, 0}));
  EXPECT_NEAR(around(*narrow, under, .2f).clearance, .01f, 1e-5f);
  EXPECT_EQ(around(*wide, under, .2f).clearance, INFINITE);

  // Photons beside the block do not count in the gap, and photons in the gap do not count beside it.
  GatherSettings settings;
  settings.radius = .2f;
  settings.nearest = 0;
  const auto onSide = [](bool beyond) {
    return [beyond](uint64_t seed) {
      std::vector<Photon> list = onFloor(seed, 20000);
      std::erase_if(list, [&](const Photon& p) { return (p.position.x > .5f) != beyond; });
      return list;
    };
  };
  EXPECT_EQ(estimateOverTruth(*narrow, beside, settings, 4, onSide(true), true).value, 0);
  EXPECT_GT(estimateOverTruth(*wide, beside, settings, 4, onSide(true), true).value, .05);
  const Ray inside{{.56f, .1f, .005f}, {0, 0, -1}};
  EXPECT_EQ(estimateOverTruth(*narrow, inside, settings, 4, onSide(false), true).value, 0);
  EXPECT_GT(estimateOverTruth(*wide, inside, settings, 4, onSide(false), true).value, .05);
}

TEST(BoundaryCorrection, ClearGlassAboveASurfaceIsNoGap) {
  // The foot of a wine glass on a table: all light passes through it, so that supports keep their size.
  const auto below = [](const std::string& material) {
    return sceneOf(FLOOR + "Material \"" + material + "\"\n" +
                   quad("-1 -1 .01  1 -1 .01  1 1 .01  -1 1 .01") +
                   quad("-1 -1 .02  1 -1 .02  1 1 .02  -1 1 .02") + "Material \"diffuse\"\n" +
                   quad("-1 -1 .05  1 -1 .05  1 1 .05  -1 1 .05"));
  };
  const Ray down{{.1f, .1f, .005f}, {0, 0, -1}};
  EXPECT_NEAR(around(*below("dielectric"), down, .2f).clearance, .05f, 1e-5f);
  EXPECT_NEAR(around(*below("thindielectric"), down, .2f).clearance, .05f, 1e-5f);
  EXPECT_NEAR(around(*below("interface"), down, .2f).clearance, .05f, 1e-5f);
  EXPECT_NEAR(around(*below("conductor"), down, .2f).clearance, .01f, 1e-5f);
  EXPECT_NEAR(around(*below("diffuse"), down, .2f).clearance, .01f, 1e-5f);
}

/** A floor with a ceiling close above it, which reduces a support of .2 to the height of the gap. */
class NarrowGap {
 public:
  NarrowGap() {
    EXPECT_TRUE(scene->intersect({{.1f, .1f, .005f}, {0, 0, -1}}, hit));
    settings.radius = .2f;
  }
  GatherResult estimate(const PhotonMap& map, float& radiance, uint32_t seed = 5) const {
    BsdfArena arena;
    const ScatteringPoint scattering(*hit.material->bsdfAt(hit.point, arena), hit.point);
    const PathClasses classes;
    TransportCounts counts;
    PathRadiance out(classes, counts);
    BoundaryCorrection boundary{*scene, Sampler(seed, 0, 0)};
    const GatherResult result = gather(map, settings, scattering, hit.point, {0, 0, 1}, 0, Rgb(1),
                                       classes.step(classes.cameraStart(), PathEvent::D), out, &boundary);
    radiance = luminance(out.scattered());
    return result;
  }

  GatherSettings settings;

 private:
  std::unique_ptr<Scene> scene = sceneOf(FLOOR + quad("-1 -1 .01  -1 1 .01  1 1 .01  1 -1 .01"));
  Hit hit;
};

TEST(BoundaryCorrection, PhotonsWeighByTheSupportThatIsUsed) {
  NarrowGap gap;
  PhotonMap map;
  map.build(onFloor(1, 20000));
  gap.settings.weighedAgainstRays = true;
  gap.settings.mergeDensity = 3;
  float radiance = 0;
  gap.settings.leavesLightToRays = true;
  const GatherResult result = gap.estimate(map, radiance);
  EXPECT_LT(result.radius, .05f);
  EXPECT_NEAR(result.mergeDensity, 3 * PI * square(result.radius), 1e-6f);
  // Where estimates are left out at random, weights do not depend on the outcome.
  gap.settings.leavesLightToRays = false;
  EXPECT_NEAR(gap.estimate(map, radiance).mergeDensity, 3 * PI * square(.2f), 1e-5f);
}

TEST(BoundaryCorrection, FaintEstimatesAreMadeAtRandomWithTheSameMean) {
  NarrowGap gap;
  PhotonMap map;
  map.build(onFloor(1, 20000));
  float whole = 0;
  gap.estimate(map, whole);
  const auto made = [&](float expected) {
    gap.settings.expected = expected;
    const uint32_t count = 2000;
    double sum = 0, squares = 0;
    uint32_t some = 0;
    for (uint32_t i = 0; i < count; ++i) {
      float radiance = 0;
      gap.estimate(map, radiance, i);
      sum += double(radiance / whole) / count;
      squares += square(double(radiance / whole)) / count;
      some += radiance > 0;
    }
    EXPECT_NEAR(sum, 1, 4 * std::sqrt((squares - square(sum)) / count) + 1e-3);
    return some / double(count);
  };
  const float irradiance = 3 * float(IRRADIANCE);
  EXPECT_EQ(made(irradiance), 1);
  EXPECT_NEAR(made(40 * irradiance), .25, .05);
  // Never so rarely that one estimate would be a dot: supports may shrink after the decision.
  EXPECT_NEAR(made(1e4f * irradiance), .1, .03);
}

TEST(BoundaryCorrection, ASmallerSupportLeavesMoreToRays) {
  NarrowGap gap;
  GatherSettings& settings = gap.settings;
  PhotonMap map, elsewhere;
  map.build(onFloor(1, 20000));
  std::vector<Photon> behind = onFloor(1, 20000);
  std::erase_if(behind, [](const Photon& p) { return p.position.x > -.5f; });
  elsewhere.build(behind);
  float whole = 0, part = 0, none = 0;
  EXPECT_EQ(gap.estimate(map, whole).unknownWeight, 1);
  settings.errors = {1, .01};
  ASSERT_EQ(settings.errors.photonWeight(1), 1);
  for (const bool weighed : {false, true}) {
    settings.leavesLightToRays = true;
    settings.weighedAgainstRays = weighed;
    const GatherResult used = gap.estimate(map, part);
    ASSERT_LT(used.radius, .05f);
    const float left = square(used.radius / settings.radius);
    EXPECT_NEAR(used.unknownWeight, weighed ? settings.errors.photonWeight(double(left)) : left, 1e-5f);
    EXPECT_LT(used.unknownWeight, .99f);
    EXPECT_NEAR(part, used.unknownWeight * whole, 1e-5f * whole);
    // The weight of rays does not depend on the presence of photons.
    EXPECT_EQ(gap.estimate(elsewhere, none).unknownWeight, used.unknownWeight);
  }
}

TEST(BoundaryCorrection, APlaceBehindAWallTellsNothing) {
  const ThreadPool pool;
  const auto scene = sceneOf(FLOOR + WALL);
  // Many photons behind the wall, few in front of it: the radius must suit the few photons up to the wall.
  std::vector<Photon> list;
  int count = 0;
  for (const Photon& p : onFloor(1, 20000)) {
    if (p.position.x < 0.5f && ++count % 20 != 0) continue;
    list.push_back(p);
  }
  PhotonMap map;
  map.build(list);
  RadiusCache field;
  TransportCounts counts;
  const GatherSettings search = nearestWithin(20, 1);
  field.build(*scene, map, 0, {}, search, 0, LightDetail::SMOOTH, {}, counts);
  const CachedRadius before = field.at(Vec3f(0.48f, 0, 0), {0, 0, 1});
  const CachedRadius behind = field.at(Vec3f(0.7f, 0, 0), {0, 0, 1});
  ASSERT_TRUE(behind.known);
  EXPECT_LT(2 * behind.radius, before.radius);
  EXPECT_TRUE(!before.known || before.known->sees(Vec3f(0.48f, 0, 0)));
}

TEST(BoundaryCorrection, DiscsByNoiseAndBlur) {
  const ThreadPool pool;
  const auto scene = sceneOf(FLOOR);
  // Ratio of the radius found in the middle of the floor to the distance of the nearest photons, for light in
  // stripes.
  const auto widening = [&](float stripe, int nearest) {
    std::vector<Photon> list;
    for (const Photon& p : onFloor(7, 40000))
      if (std::fmod(p.position.x + 4, 2 * stripe) < stripe) list.push_back(p);
    PhotonMap map;
    map.build(list);
    const GatherSettings search = nearestWithin(nearest, 1);
    const auto radius = [&](double alpha) {
      RadiusCache field;
      TransportCounts counts;
      field.build(*scene, map, 0, {}, search, alpha, LightDetail::SMOOTH, {}, counts);
      double mean = 0;
      for (int i = 0; i < 100; ++i)
        mean += double(field.at(Vec3f(-0.2f + 0.004f * float(i), 0, 0), {0, 0, 1}).radius);
      return mean / 100;
    };
    return radius(2.0 / 3) / radius(0);
  };
  EXPECT_GT(widening(4, 40), 1.3) << "even light bears large discs";
  EXPECT_LT(widening(0.06f, 40), 1.05) << "stripes as wide as a disc do not";
  EXPECT_LT(widening(0.12f, 150), 1.05) << "nor do wider ones that more photons tell of";
}

namespace {

/** Grid of 60 x 60 points on the floor, up to `half` from the middle. */
std::vector<VisiblePoint> seenOnFloor(float half) {
  std::vector<VisiblePoint> seen;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 60; ++x) {
      VisiblePoint visible{};
      visible.point.position = Vec3f(-half + 2 * half * float(x) / 60, -half + 2 * half * float(y) / 60, 0);
      visible.point.geometricNormal = visible.point.shadingNormal = {0, 0, 1};
      visible.footprint = 0.002f;
      seen.push_back(visible);
    }
  return seen;
}

} // namespace

TEST(BoundaryCorrection, FewStrongPhotonsDoNotPassForBlur) {
  const ThreadPool pool;
  const auto scene = sceneOf(FLOOR);
  std::vector<Photon> list = onFloor(3, 2000); // uniform light, most of it from one photon in twenty
  for (size_t i = 0; i < list.size(); i += 20) list[i].power *= 50.0f;
  PhotonMap map;
  map.build(list);
  // A close view: many points whose estimates use the same photons.
  const std::vector<VisiblePoint> seen = seenOnFloor(0.2f);
  const GatherSettings search = nearestWithin(8, 1);
  TransportCounts counts;
  RadiusCache nearest, judged;
  nearest.build(*scene, map, 0, seen, search, 0, LightDetail::SMOOTH, {}, counts);
  judged.build(*scene, map, 0, seen, search, 2.0 / 3, LightDetail::SMOOTH, {}, counts);
  int smaller = 0;
  for (const VisiblePoint& v : seen) {
    const auto radius = [&](const RadiusCache& cache) {
      return cache.at(v.point.position, {0, 0, 1}).radius;
    };
    smaller += radius(judged) < 0.99f * radius(nearest);
  }
  EXPECT_LT(smaller, 36) << "of 3600";
}

TEST(BoundaryCorrection, DiscsOfFineLightStaySmall) {
  const ThreadPool pool;
  const auto scene = sceneOf(FLOOR);
  PhotonMap map;
  map.build(onFloor(4, 20000)); // the light is uniform: wide discs are correct
  const std::vector<VisiblePoint> seen = seenOnFloor(0.2f);
  const GatherSettings search = nearestWithin(8, 1);
  TransportCounts counts;
  RadiusCache nearest, smooth, fine;
  nearest.build(*scene, map, 0, seen, search, 0, LightDetail::SMOOTH, {}, counts);
  smooth.build(*scene, map, 0, seen, search, 2.0 / 3, LightDetail::SMOOTH, {}, counts);
  fine.build(*scene, map, 0, seen, search, 2.0 / 3, LightDetail::FINE, {}, counts);
  double mean = 0, meanSmooth = 0, meanFine = 0;
  for (const VisiblePoint& v : seen) {
    const auto radius = [&](const RadiusCache& cache) {
      return double(cache.at(v.point.position, {0, 0, 1}).radius);
    };
    mean += radius(nearest);
    meanSmooth += radius(smooth);
    meanFine += radius(fine);
  }
  EXPECT_GT(meanSmooth, 2 * mean);
  EXPECT_LT(meanFine, 1.5 * mean);
}

TEST(BoundaryCorrection, ASmallPoolOfLightDoesNotSpread) {
  const ThreadPool pool;
  const auto scene = sceneOf(FLOOR);
  std::vector<Photon> list = onFloor(5, 20000);
  for (Photon& p : list) p.position = p.position * 0.05f + Vec3f(0.8f, 0, 0);
  PhotonMap map;
  map.build(list);
  const std::vector<VisiblePoint> seen = seenOnFloor(0.9f);
  const GatherSettings search = nearestWithin(8, 2);
  TransportCounts counts;
  RadiusCache cache;
  cache.build(*scene, map, 0, seen, search, 2.0 / 3, LightDetail::SMOOTH, {}, counts);
  int reach = 0;
  for (const VisiblePoint& v : seen) {
    const float away = glm::distance(v.point.position, Vec3f(0.8f, 0, 0));
    reach += away > 0.3f && cache.at(v.point.position, {0, 0, 1}).radius > away - 0.05f;
  }
  EXPECT_LT(reach, 36) << "of 3600";
}

// Where photons are far apart, the radius of the search is as large as the room. The lookup of the radius on
// a wall must not find records on the ceiling.
TEST(BoundaryCorrection, APoolOfLightOnTheCeilingDoesNotHideTheWalls) {
  const ThreadPool pool;
  const auto scene = sceneOf("Shape \"box\" \"point3 p1\" [ -1 -1 -1 ] \"point3 p2\" [ 1 1 1 ]\n");
  std::vector<Photon> list = onFloor(5, 20000);
  for (Photon& p : list) {
    p.position = 0.05f * p.position + Vec3f(0, 0, 1);
    p.direction = packDirection({0, 0, -1});
    p.normal = packDirection({0, 0, -1});
  }
  const auto onWall = [](const Vec3f& p) { return Vec3f(-1, p.x, p.y); };
  for (const Photon& p : onFloor(6, 500)) {
    list.push_back(p);
    list.back().position = onWall(p.position);
    list.back().direction = list.back().normal = packDirection({1, 0, 0});
  }
  std::vector<VisiblePoint> seen = seenOnFloor(0.2f);
  for (VisiblePoint& v : seen) {
    v.point.position = onWall(v.point.position);
    v.point.geometricNormal = v.point.shadingNormal = {1, 0, 0};
  }
  PhotonMap map;
  map.build(list);
  TransportCounts counts;
  RadiusCache cache;
  cache.build(*scene, map, 0, {}, nearestWithin(8, 1), 2.0 / 3, LightDetail::FINE, {}, counts);
  int wide = 0;
  for (const VisiblePoint& v : seen) wide += cache.at(v.point.position, {1, 0, 0}).radius > 0.5f;
  EXPECT_LT(wide, 36) << "of 3600";
}

TEST(BoundaryCorrection, RecordsOnAFlatFloorShareProbes) {
  const ThreadPool pool;
  const auto scene = sceneOf(FLOOR);
  PhotonMap map;
  map.build(onFloor(6, 20000));
  const std::vector<VisiblePoint> seen = seenOnFloor(0.8f);
  const GatherSettings search = nearestWithin(20, 1);
  for (const double alpha : {0.0, 2.0 / 3}) {
    TransportCounts counts;
    RadiusCache cache;
    cache.build(*scene, map, 0, seen, search, alpha, LightDetail::SMOOTH, {}, counts);
    double known = 0;
    for (size_t i = 0; i < cache.size(); ++i) {
      const RadiusCache::Record& record = cache.record(i);
      known += record.around.reach >= 1.5f * record.radius;
    }
    EXPECT_EQ(known, double(cache.size()));
    if (alpha == 0) {
      EXPECT_LT(double(counts.rays), 70 * double(cache.size())) << "a record that probes takes more than 100";
    }
  }
}

TEST(BoundaryCorrection, ASheetCloseToTheFloorIsNotTheFloor) {
  // A record on the floor knows a flat floor far beyond the height of the sheet.
  const ThreadPool pool;
  const auto scene = sceneOf(FLOOR);
  PhotonMap map;
  map.build(onFloor(6, 2000));
  const GatherSettings search = nearestWithin(20, 1);
  TransportCounts counts;
  RadiusCache cache;
  cache.build(*scene, map, 0, {}, search, 0, LightDetail::SMOOTH, {}, counts);
  for (size_t i = 0; i < cache.size(); i += 16) {
    const RadiusCache::Record& record = cache.record(i);
    const Vec3f beside = record.position + Vec3f(0.2f * record.around.flat, 0, 0);
    if (!(record.around.flat > 0) || !record.around.sees(beside)) continue;
    EXPECT_TRUE(record.isOnSurfaceOf(beside, {0, 0, 1}));
    EXPECT_FALSE(record.isOnSurfaceOf(beside + Vec3f(0, 0, 0.01f * record.around.flat), {0, 0, 1}));
    EXPECT_FALSE(record.isOnSurfaceOf(beside - Vec3f(0, 0, 0.01f * record.around.flat), {0, 0, 1}));
    EXPECT_FALSE(record.isOnSurfaceOf(beside, {0, 0, -1}));
  }
}

TEST(BoundaryCorrection, PhotonsInOnePointTellNoRadius) {
  const ThreadPool pool;
  const auto scene = sceneOf(FLOOR);
  // More coincident photons than the search asks for, at a visible point.
  const Vec3f point(0.5f, 0.25f, 0);
  std::vector<Photon> coincident = onFloor(1, 12);
  for (Photon& p : coincident) p.position = point;
  std::vector<Photon> all = onFloor(2, 2000);
  all.insert(all.end(), coincident.begin(), coincident.end());
  Hit hit;
  ASSERT_TRUE(scene->intersect(down(point.x, point.y), hit));
  hit.point.position = point;
  const std::vector<VisiblePoint> seen = {{hit.point, 0.01f}};
  const GatherSettings search = nearestWithin(8, 1);
  for (const double alpha : {0.0, 2.0 / 3}) {
    TransportCounts counts;
    RadiusCache cache, ofThose;
    ofThose.build(
        *scene,
        [&] {
          PhotonMap map;
          map.build(coincident);
          return map;
        }(),
        0, seen, search, alpha, LightDetail::SMOOTH, {}, counts);
    EXPECT_EQ(ofThose.size(), 0u);
    EXPECT_GT(ofThose.at(point, {0, 0, 1}).radius, 0);
    PhotonMap map;
    map.build(all);
    cache.build(*scene, map, 0, seen, search, alpha, LightDetail::SMOOTH, {}, counts);
    EXPECT_GT(cache.size(), 0u);
    for (size_t i = 0; i < cache.size(); ++i) EXPECT_GT(cache.record(i).radius, 0);
    EXPECT_GT(cache.at(point, {0, 0, 1}).radius, 0);
  }
}

TEST(Gather, TakesPhotonsInOnePointOverTheWholeSupport) {
  const auto scene = sceneOf(FLOOR);
  Hit hit;
  ASSERT_TRUE(scene->intersect(down(0.5f, 0.25f), hit));
  std::vector<Photon> list = onFloor(1, 8);
  double power = 0;
  for (Photon& p : list) {
    p.position = hit.point.position;
    power += double(p.power.g);
  }
  PhotonMap map;
  map.build(list);
  GatherSettings search = nearestWithin(8, 0.5f);
  search.kernel = Kernel::CONSTANT;
  BsdfArena arena;
  const ScatteringPoint scattering(*hit.material->bsdfAt(hit.point, arena), hit.point);
  const PathClasses classes;
  TransportCounts counts;
  PathRadiance out(classes, counts);
  gather(map, search, scattering, hit.point, {0, 0, 1}, 0, Rgb(1),
         classes.step(classes.cameraStart(), PathEvent::D), out);
  const double density = power / (M_PI * square(0.5));
  EXPECT_NEAR(double(out.total().g), ALBEDO / M_PI * density, 1e-4 * density);
}
