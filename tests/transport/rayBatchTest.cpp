/** @file
 * Rays and camera paths in batches against single ones.
 */
#include <random>

#include "transport/rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Every kind of intersection: triangles, user geometry, instances of both, holes. */
const std::string ROOM = view(16, "0 -3 1.5  0 0 .8  0 0 1", 60) + R"(
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [8 8 8]
  Shape "bilinearmesh" "point3 P" [-.5 -.5 3  -.5 .5 3  .5 -.5 3  .5 .5 3]
AttributeEnd
LightSource "point" "point3 from" [2 -2 2] "rgb I" [1 1 1]
Material "diffuse" "rgb reflectance" [.7 .6 .5]
Shape "trianglemesh" "point3 P" [-3 -3 0  3 -3 0  -3 3 0  3 3 0] "integer indices" [0 1 3 0 3 2]
Shape "sphere" "float radius" .4
ObjectBegin "thing"
  Shape "sphere" "float radius" .3
  Shape "trianglemesh" "point3 P" [-.5 0 -.5  .5 0 -.5  0 0 .5] "integer indices" [0 1 2]
ObjectEnd
AttributeBegin Translate 1 .2 1 Scale 1 2 .5 ObjectInstance "thing" AttributeEnd
AttributeBegin Translate -1 .2 1 ObjectInstance "thing" AttributeEnd
Texture "holes" "float" "checkerboard" "float uscale" 5 "float vscale" 5
AttributeBegin
  Material "dielectric"
  Translate 0 1 1
  Shape "sphere" "float radius" .5
AttributeEnd
Shape "bilinearmesh" "point3 P" [-1 -1 2  1 -1 2  -1 1 2  1 1 2] "texture alpha" "holes"
)";

std::vector<Ray> randomRays(size_t count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> number(-1, 1);
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const Vec3f origin(2 * number(random), 2 * number(random), 1.5f + 1.4f * number(random));
    const Vec3f direction(number(random), number(random), number(random));
    if (glm::length(direction) < .1f) continue;
    const float tMax = rays.size() % 3 == 0 ? 1.5f : std::numeric_limits<float>::infinity();
    rays.push_back({origin, glm::normalize(direction), tMax});
  }
  return rays;
}

} // namespace

TEST(RayBatch, PlacesAreThoseOfHits) {
  const auto scene = sceneFrom(ROOM);
  for (const Ray& ray : randomRays(5000)) {
    Hit hit, place;
    ASSERT_EQ(scene->intersectPosition(ray, place), scene->intersect(ray, hit));
    EXPECT_EQ(place.t, hit.t);
    if (hit.t == 0) continue;
    EXPECT_EQ(place.material, hit.material);
    EXPECT_EQ(place.areaLight, hit.areaLight);
    EXPECT_EQ(place.point.position, hit.point.position);
    EXPECT_EQ(place.point.error, hit.point.error);
    EXPECT_EQ(place.point.geometricNormal, hit.point.geometricNormal);
  }
}

TEST(RayBatch, NearestHitsAreThoseOfSingleRays) {
  const auto scene = sceneFrom(ROOM);
  for (const size_t count :
       {size_t(1), size_t(2), size_t(7), size_t(8), size_t(64), size_t(65), size_t(5000)}) {
    const std::vector<Ray> rays = randomRays(count);
    for (const auto coherence : {Scene::Coherence::NONE, Scene::Coherence::COHERENT}) {
      std::vector<Hit> hits(count);
      scene->intersectBatch(rays, coherence, hits);
      size_t met = 0;
      for (size_t i = 0; i < count; ++i) {
        Hit alone;
        const bool hit = scene->intersect(rays[i], alone);
        ASSERT_EQ(hits[i].t < std::numeric_limits<float>::infinity(), hit) << i;
        if (!hit) continue;
        ++met;
        ASSERT_NEAR(hits[i].t, alone.t, 1e-5f * (1 + alone.t)) << i;
        ASSERT_EQ(hits[i].material, alone.material);
        ASSERT_EQ(hits[i].areaLight, alone.areaLight);
        ASSERT_EQ(hits[i].primitive, alone.primitive);
        ASSERT_LT(glm::length(hits[i].point.position - alone.point.position), 1e-5f);
        ASSERT_LT(glm::length(hits[i].point.geometricNormal - alone.point.geometricNormal), 1e-5f);
      }
      if (count > 100) {
        EXPECT_GT(met, count / 4);
        EXPECT_LT(met, count);
      }
    }
  }
}

TEST(RayBatch, ShadowsAreThoseOfSingleRays) {
  const auto scene = sceneFrom(ROOM);
  for (const size_t count : {size_t(1), size_t(3), size_t(9), size_t(64), size_t(70), size_t(5000)}) {
    const std::vector<Ray> rays = randomRays(count);
    std::vector<uint8_t> blocked(count);
    scene->occludedBatch(rays, blocked);
    size_t dark = 0;
    for (size_t i = 0; i < count; ++i) {
      ASSERT_EQ(blocked[i] != 0, scene->occluded(rays[i])) << i;
      dark += blocked[i] != 0;
    }
    if (count > 100) {
      EXPECT_GT(dark, count / 4);
      EXPECT_LT(dark, count);
    }
  }
}

/** Rounding may change one of many walks; mixing up walks would change nearly all of them. */
TEST(RayBatch, WalksDoNotTouchEachOther) {
  const auto scene = sceneFrom(ROOM);
  const auto integrator = integratorFrom("path", "");
  const PathClasses classes;
  TransportCounts counts;
  constexpr size_t COUNT = 300; // more than one batch
  std::vector<PathRadiance> together(COUNT, PathRadiance(classes, counts));
  std::vector<CameraPath> paths;
  size_t differing = 0, lit = 0;
  const auto path = [&](size_t i, PathRadiance& out) {
    CameraPath p(Sampler(7, i / 4, static_cast<uint32_t>(i % 4)), out);
    p.ray = *scene->camera().sampleRay({Vec2f(float(i % 16), float(i / 16 % 16)) + p.sampler.next2D()});
    return p;
  };
  for (size_t i = 0; i < COUNT; ++i) paths.push_back(path(i, together[i]));
  integrator->backwardBatch(*scene, paths);
  for (size_t i = 0; i < COUNT; ++i) {
    PathRadiance alone(classes, counts);
    CameraPath p = path(i, alone);
    integrator->backward(*scene, p.ray, p.sampler, alone);
    const float a = luminance(alone.total()), b = luminance(together[i].total());
    lit += a > 0;
    differing += std::abs(a - b) > 1e-3f * a;
  }
  EXPECT_GT(lit, COUNT / 5);
  EXPECT_LE(differing, COUNT / 50);
}
