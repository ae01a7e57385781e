/** @file
 * Shadow rays through learned portals: densities, and the light through a hole against its solid angle.
 */
#include "transport/direct/portalSampler.h"
#include "transport/roomWithHole.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

bool leavesByHole(const Vec3f& point, const Vec3f& direction, const Vec3f& center) {
  return direction.y > 0 && crossesHole(point, direction, center);
}

/** Mean and second moment of the irradiance through the hole by shadow rays. */
struct ShadowMoments {
  double mean = 0, second = 0;
};
template <class Sample>
ShadowMoments irradianceThroughHole(const Vec3f& point, const Vec3f& center, const Sample& sample) {
  constexpr int N = 400000;
  ShadowMoments sum;
  Sampler sampler(5, 0, 0);
  for (int i = 0; i < N; ++i) {
    const float pick = sampler.next1D();
    const std::optional<LiSample> s = sample(pick, sampler.next2D());
    if (!s || !leavesByHole(point, s->direction, center)) continue;
    const double brought = double(s->radiance.r * s->direction.y / s->pdf);
    sum.mean += brought / N;
    sum.second += brought * brought / N;
  }
  return sum;
}

} // namespace

TEST(PortalSampler, BringsTheLightOfAHoleWithLittleVariance) {
  const auto scene = sceneFrom(roomWithHole(96));
  ASSERT_TRUE(scene);
  PortalSampler portals;
  portals.learn(*scene);
  ASSERT_TRUE(portals.active());
  const EnvironmentLight& light = *scene->environment()[0];
  const Vec3f center = scene->bounds().center;
  for (const Vec3f& place : {Vec3f(0, -1.25f, 0), Vec3f(1, -1.25f, -0.7f), Vec3f(-1.5f, -1, 1.5f)}) {
    const Vec3f point = center + place;
    // Integral of the cosine over the hole's solid angle, by the midpoint rule.
    constexpr int CELLS = 200;
    double expected = 0;
    for (int x = 0; x < CELLS; ++x)
      for (int z = 0; z < CELLS; ++z) {
        const Vec3d at((2 * (x + 0.5) / CELLS - 1) * double(HOLE_HALF_WIDTH), 1.25,
                       (2 * (z + 0.5) / CELLS - 1) * double(HOLE_HALF_WIDTH));
        const Vec3d way = at - Vec3d(place);
        expected += square(way.y) / square(glm::dot(way, way)) * square(2 * double(HOLE_HALF_WIDTH) / CELLS);
      }
    const ShadowMoments through = irradianceThroughHole(
        point, center, [&](float pick, const Vec2f& u) { return portals.sampleLi(light, point, pick, u); });
    const ShadowMoments own = irradianceThroughHole(
        point, center, [&](float pick, const Vec2f& u) { return light.sampleLi(point, pick, u); });
    EXPECT_NEAR(through.mean / expected, 1, 0.01);
    EXPECT_LT(through.second, own.second / 10);
  }
}

TEST(PortalSampler, DensitiesAreThoseOfTheSamples) {
  const auto scene = sceneFrom(roomWithHole(96));
  ASSERT_TRUE(scene);
  PortalSampler portals;
  portals.learn(*scene);
  ASSERT_TRUE(portals.active());
  const EnvironmentLight& light = *scene->environment()[0];
  const Vec3f center = scene->bounds().center;
  constexpr int N = 400000;
  for (const Vec3f& place :
       {Vec3f(0.1f, -1, 0), Vec3f(1.9f, 1.2f, 0.3f), Vec3f(0, 1.25f, 0), Vec3f(0.5f, 4, 0)}) {
    Sampler sampler(7, 0, 0);
    double sphere = 0;
    for (int i = 0; i < N; ++i) {
      const float pick = sampler.next1D();
      const std::optional<LiSample> s = portals.sampleLi(light, center + place, pick, sampler.next2D());
      ASSERT_TRUE(s);
      EXPECT_NEAR(portals.pdfLi(light, center + place, s->direction), s->pdf, 1e-3f * s->pdf);
      sphere += 1 / double(s->pdf) / N;
    }
    EXPECT_NEAR(sphere / (4 * M_PI), 1, 0.02);
  }
}

TEST(PortalSampler, APaneIsAPortal) {
  const auto scene =
      sceneFrom(roomWithHole(96, "Material \"thindielectric\" Shape \"bilinearmesh\" \"point3 P\" "
                                 "[-.2 2.5 -.2 .2 2.5 -.2 -.2 2.5 .2 .2 2.5 .2]"));
  ASSERT_TRUE(scene);
  PortalSampler portals;
  portals.learn(*scene);
  EXPECT_TRUE(portals.active());
}

TEST(PortalSampler, TheSunInAFewPlacesDoesNotOutweighTheSkyInAllOthers) {
  std::string room = roomWithHole(96);
  const std::string even = "LightSource \"infinite\" \"rgb L\" [1 1 1]";
  room.replace(room.find(even), even.size(), R"(
AttributeBegin
Rotate -90 1 0 0
LightSource "sky" "float turbidity" 3 "float elevation" 60 "float azimuth" 200
AttributeEnd)");
  const auto scene = sceneFrom(room);
  ASSERT_TRUE(scene);
  PortalSampler portals;
  portals.learn(*scene);
  EXPECT_GT(portals.probability(), 0);
  EXPECT_LT(portals.probability(), 0.5f);
}

TEST(PortalSampler, IsLeftOutUnderTheOpenSky) {
  const auto scene = sceneFrom(view(96, "0 2 5  0 0 0  0 1 0", 60) + R"(
LightSource "infinite" "rgb L" [1 1 1]
Shape "bilinearmesh" "point3 P" [-9 0 -9  9 0 -9  -9 0 9  9 0 9]
Shape "sphere")");
  ASSERT_TRUE(scene);
  PortalSampler portals;
  portals.learn(*scene);
  EXPECT_FALSE(portals.active());
}

TEST(PortalSampler, TheRoomIsAsBrightAsWithoutPortals) {
  constexpr int SMALL = 8; // too few camera paths to find portals
  const auto scene = sceneFrom(roomWithHole(SMALL));
  ASSERT_TRUE(scene);
  PortalSampler portals;
  portals.learn(*scene);
  ASSERT_FALSE(portals.active());
  const int count = 16;
  const Rendered with = renderText(roomWithHole(96), "path", "", count);
  const Rendered without = renderText(roomWithHole(SMALL), "path", "", 2000 * count);
  const double error = std::hypot(with.standardError(), without.standardError());
  EXPECT_LT(error, 0.02 * without.mean());
  EXPECT_NEAR(with.mean() / without.mean(), 1, 0.005 + 3 * error / without.mean());
}
