/** @file
 * Light selection learned from photons: probabilities against each other and against visibility, shadow rays
 * against selection without a guide.
 */
#include <map>

#include "integrators/path/pathTracing.h"
#include "integrators/photonmap/photonMapping.h"
#include "transport/direct/directLight.h"
#include "transport/learning/lightLearning.h"
#include "transport/rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

constexpr int ROOMS = 40;

/** Closed rooms in a row, each with a lamp. */
std::string rooms() {
  std::string s = view(16, ".1 .5 .5  1 .5 .2  0 0 1", 70);
  s += "Material \"diffuse\" \"rgb reflectance\" [.6 .6 .6]\n";
  for (int i = 0; i < ROOMS; ++i)
    s += "AttributeBegin Translate " + std::to_string(i) + R"( 0 0
      Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0] Shape "bilinearmesh" "point3 P" [0 0 1 1 0 1 0 1 1 1 1 1]
      Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 0 1 1 0 1] Shape "bilinearmesh" "point3 P" [0 1 0 1 1 0 0 1 1 1 1 1]
      Shape "bilinearmesh" "point3 P" [0 0 0 0 1 0 0 0 1 0 1 1] Shape "bilinearmesh" "point3 P" [1 0 0 1 1 0 1 0 1 1 1 1]
      LightSource "point" "point3 from" [.5 .5 .9]
    AttributeEnd
    )";
  return s;
}

/** Every kind of light, including one without power, above and beyond a translucent curtain. */
std::string yard() {
  std::string s = view(16, "0 -3 2  0 0 .2  0 0 1", 40) + R"(
    LightSource "infinite" "rgb L" [.1 .1 .2]
    LightSource "distant" "point3 from" [1 2 3] "rgb L" [2 2 1]
    LightSource "point" "point3 from" [.5 0 .7] "rgb I" [0 0 0]
    LightSource "spot" "point3 from" [0 1 1] "point3 to" [0 0 0] "rgb I" [3 2 1]
    Material "diffusetransmission"
    Shape "bilinearmesh" "point3 P" [-1 0 0  1 0 0  -1 0 1  1 0 1]
    Material "diffuse"
    Shape "bilinearmesh" "point3 P" [-2 -2 0  2 -2 0  -2 2 0  2 2 0]
    Shape "sphere" "float radius" .3
  )";
  for (int i = 0; i < 7; ++i)
    s += "LightSource \"point\" \"point3 from\" [" + std::to_string(i - 3) + " .5 1] \"rgb I\" [1 1 1]\n";
  // Two lamps at the same position.
  for (int i = 0; i < 2; ++i) s += "LightSource \"point\" \"point3 from\" [0 -1 .5] \"rgb I\" [1 1 1]\n";
  s += "AreaLightSource \"diffuse\" \"rgb L\" [5 5 5] Translate 1 1 1 Shape \"sphere\" \"float radius\" .2\n";
  return s;
}

LightSampler learned(const Scene& scene, int threads = 0) {
  const ThreadPool pool(threads);
  LightSampler guide;
  learnLights(scene, guide);
  return guide;
}

/** Calls `visit(context, sampler)` for random points around the scene, and a few far away. */
template <class Visit> void visitPlaces(const Scene& scene, const LightSampler& guide, const Visit& visit) {
  for (uint32_t i = 0; i < 200; ++i) {
    Sampler sampler(1, 2, i);
    const float reach = scene.bounds().radius * (i % 10 == 0 ? 100.0f : 1.0f);
    const Vec3f offset(sampler.next2D() * 2.0f - 1.0f, sampler.next1D() * 2 - 1);
    const Vec3f normal = uniformSphere(sampler.next2D());
    visit(guide.at(scene.bounds().center + offset * reach, normal), sampler);
  }
}

/** Mean and variance of direct light by one shadow ray, at visible points and at points one bounce
 * further. */
struct Shadows {
  double mean = 0, variance = 0;
};
Shadows shadowRays(const Scene& scene, const LightSampler& guide, int rays) {
  const PathClasses classes;
  const CameraState eye = classes.step(classes.cameraStart(), PathEvent::D);
  TransportCounts counts;
  PathRadiance out(classes, counts);
  BsdfArena arena;
  Shadows all;
  constexpr uint32_t PLACES = 100;
  for (uint32_t i = 0; i < PLACES; ++i) {
    Sampler where(3, 4, i);
    Ray ray = *scene.camera().sampleRay({where.next2D() * 16.0f});
    Hit hit;
    if (!intersect(scene, ray, hit, counts)) continue;
    if (i % 2) { // next surface along a random direction
      const Vec3f& n = hit.point.geometricNormal;
      const Frame frame(glm::dot(n, ray.direction) < 0 ? n : -n);
      ray = spawn(hit.point, frame.toWorld(cosineHemisphere(where.next2D())));
      if (!intersect(scene, ray, hit, counts)) continue;
    }
    arena.reset();
    const Bsdf* bsdf = bsdfAt(hit, Footprint(), arena);
    if (!bsdf) continue;
    const ScatteringPoint scattering(*bsdf, hit.point);
    const Vec3f wi = -ray.direction;
    const LightSampleContext place = lightSampleContext(guide, hit.point, wi);
    double sum = 0, squares = 0;
    for (int n = 0; n < rays; ++n) {
      Sampler sampler(5, i, uint32_t(n));
      out.reset();
      addSampledLight(scene, guide, place, scattering, hit, {}, wi, Rgb(1), eye, 1, NON_DELTA_LOBES, 0,
                      sampler, out);
      const double y = double(luminance(out.total()));
      sum += y / rays;
      squares += y * y / rays;
    }
    all.mean += sum / PLACES;
    all.variance += (squares - sum * sum) / PLACES;
  }
  return all;
}

} // namespace

TEST(LightSampler, ALampIsFoundInARoomUnderABrightSky) {
  // Nearly all photons come from the sky and hit surfaces outside; half of the photons with one direction of
  // the normal are in one plane.
  const auto scene = sceneFrom(view(96, ".1 .5 .5  1 .5 .2  0 0 1", 70) + R"(
    LightSource "infinite" "rgb L" [10 10 10]
    LightSource "point" "point3 from" [.8 .5 .8] "rgb I" [.05 .05 .05]
    Material "diffuse" "rgb reflectance" [.6 .6 .6]
    Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0] Shape "bilinearmesh" "point3 P" [0 0 1 1 0 1 0 1 1 1 1 1]
    Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 0 1 1 0 1] Shape "bilinearmesh" "point3 P" [0 1 0 1 1 0 0 1 1 1 1 1]
    Shape "bilinearmesh" "point3 P" [0 0 0 0 1 0 0 0 1 0 1 1] Shape "bilinearmesh" "point3 P" [1 0 0 1 1 0 1 0 1 1 1 1]
  )");
  ASSERT_TRUE(scene);
  const LightSampler guide = learned(*scene);
  for (const float z : {.2f, .4f, .6f, .8f}) {
    const LightSampleContext place = guide.at({1, .5f, z}, {-1, 0, 0});
    EXPECT_GT(guide.probability(scene->lights(), place, 1), 0.3f) << z;
  }
}

TEST(LightSampler, ProbabilitiesSumToOne) {
  for (const std::string& text : {rooms(), yard()}) {
    const auto scene = sceneFrom(text);
    const LightTable& lights = scene->lights();
    const LightSampler guide = learned(*scene);
    ASSERT_TRUE(guide.active());
    visitPlaces(*scene, guide, [&](const LightSampleContext& place, Sampler&) {
      double sum = 0;
      for (uint32_t i = 0; i < lights.size(); ++i) {
        const float p = guide.probability(lights, place, i);
        sum += double(p);
        ASSERT_EQ(p > 0, lights.probability(i) > 0) << i; // every light with power can be selected
      }
      ASSERT_NEAR(sum, 1, 1e-5);
    });
  }
}

TEST(LightSampler, LightsAreChosenByTheirProbabilities) {
  const auto scene = sceneFrom(yard());
  const LightTable& lights = scene->lights();
  const LightSampler guide = learned(*scene);
  visitPlaces(*scene, guide, [&](const LightSampleContext& place, Sampler&) {
    constexpr int N = 4000;
    std::map<const Light*, double> chosen, rest;
    for (int k = 0; k < N; ++k) {
      float u = (float(k) + 0.5f) / N;
      const ChosenLight c = guide.choose(lights, place, u);
      ASSERT_TRUE(u >= 0 && u < 1);
      chosen[c.light] += 1;
      rest[c.light] += double(u);
    }
    for (uint32_t i = 0; i < lights.size(); ++i) {
      const double n = double(guide.probability(lights, place, i)) * N;
      ASSERT_NEAR(chosen[&lights[i]], n, 2) << i;
      if (n <= 100) continue;
      ASSERT_NEAR(rest[&lights[i]] / n, 0.5, 0.02); // the remaining random number is uniform
    }
  });
}

TEST(LightSampler, ALampInFogIsSampledBesideASunThatDoesNotReachIt) {
  const auto scene = sceneFrom(view(8, "0 1 -3  0 1 0  0 1 0", 60) +
                               "LightSource \"distant\" \"rgb L\" [1e4 1e4 1e4]\n"
                               "LightSource \"spot\" \"point3 from\" [0 1 0]\n"
                               "Shape \"box\" \"point3 p1\" [-9 0 -9] \"point3 p2\" [9 9 9]\n");
  const LightSampler guide = learned(*scene);
  ASSERT_LT(scene->lights().probability(1), 1e-4f);
  EXPECT_GT(guide.probability(scene->lights(), {Vec3f(0, 0.5f, 0)}, 1), 0.1f);
}

TEST(LightSampler, TheSameForAnyNumberOfThreads) {
  const auto scene = sceneFrom(rooms());
  const LightSampler one = learned(*scene, 1), four = learned(*scene, 4);
  visitPlaces(*scene, one, [&](const LightSampleContext& place, Sampler& sampler) {
    const float u = sampler.next1D();
    const LightSampleContext same = four.at(place.position, {0, 0, 1});
    const LightSampleContext first = one.at(place.position, {0, 0, 1});
    float a = u, b = u;
    const ChosenLight x = one.choose(scene->lights(), first, a), y = four.choose(scene->lights(), same, b);
    ASSERT_EQ(x.light, y.light);
    ASSERT_EQ(x.probability, y.probability);
    ASSERT_EQ(a, b);
  });
}

TEST(LightSampler, WhatLearningTookIsTold) {
  const auto scene = sceneFrom(rooms());
  const ThreadPool pool(0);
  LightSampler lights;
  const uint64_t learning = learnLights(*scene, lights).rays;
  ASSERT_GT(learning, 0u);
  const auto raysOfPrepare = [&](const char* name) {
    return integratorFrom(name, "")->prepare(*scene, PathClasses()).rays;
  };
  for (const char* name : {"raycast", "whitted", "vpl", "radiosity"})
    EXPECT_EQ(raysOfPrepare(name), learning) << name;
  EXPECT_EQ(raysOfPrepare("bdpt"), learning);
  EXPECT_GT(raysOfPrepare("vcm"), learning); // also probes surfaces
  const auto raysOfFirstPass = [&](const char* name, const char* parameters) {
    const auto integrator = integratorFrom(name, parameters);
    const uint64_t before = integrator->prepare(*scene, PathClasses()).rays;
    const auto pass = [&] {
      return integrator->forward(*scene, PathClasses(), Pass(), ForwardControl()).counts.rays;
    };
    const uint64_t first = pass(), second = pass(); // the second pass has nothing to learn
    return before + first - second;
  };
  for (const char* name : {"path", "bdpt"}) EXPECT_EQ(raysOfFirstPass(name, ""), learning) << name;
  EXPECT_EQ(raysOfFirstPass("vcm", ""), raysOfPrepare("vcm")); // probes included
  EXPECT_EQ(raysOfFirstPass("auto", "\"integer passes\" 0 \"integer photons\" 2000"), learning);
  EXPECT_EQ(raysOfFirstPass("photonmap",
                            "\"integer passes\" 0 \"integer photons\" 2000 \"bool causticsonly\" true"),
            learning);
  EXPECT_EQ(raysOfFirstPass("photonmap", "\"integer passes\" 1 \"integer photons\" 2000"), learning);
  EXPECT_EQ(
      raysOfFirstPass("photonmap",
                      "\"integer passes\" 1 \"integer photons\" 2000 \"string without\" \"lightlearning\""),
      0u);
}

TEST(LightSampler, LearnsOnceForIntegratorsThatShareIt) {
  const auto scene = sceneFrom(rooms());
  const ThreadPool pool(0);
  LightSampler lights;
  ASSERT_GT(learnLights(*scene, lights).rays, 0u);
  const auto path = makePathTracing({}, &lights);
  path->prepare(*scene, PathClasses());
  EXPECT_EQ(path->forward(*scene, PathClasses(), Pass(), ForwardControl()).counts.rays, 0u);
  PhotonMappingSettings settings;
  settings.photons = 1000;
  std::unique_ptr<PhotonMapping> each[] = {std::make_unique<PhotonMapping>(settings, &lights),
                                           std::make_unique<PhotonMapping>(onlyCaustics(settings), &lights)};
  for (const auto& photons : each) {
    photons->prepare(*scene, PathClasses());
    const auto pass = [&] {
      return photons->forward(*scene, PathClasses(), Pass(), ForwardControl()).counts.rays;
    };
    const uint64_t first = pass();
    EXPECT_EQ(first, pass());
  }
}

/** Sampler that selects the visible lamp among many behind walls: the mean is the same with less noise. */
TEST(LightSampler, LampsBehindWallsAreLeftAlone) {
  const auto scene = sceneFrom(rooms());
  const int rays = SANITIZED ? 2000 : 10000;
  const Shadows without = shadowRays(*scene, {}, rays), with = shadowRays(*scene, learned(*scene), rays);
  EXPECT_NEAR(with.mean / without.mean, 1, 0.03);
  EXPECT_LT(with.variance, without.variance / 15);
}

TEST(LightSampler, TheSameLightOfAllKinds) {
  const auto scene = sceneFrom(yard());
  const int rays = SANITIZED ? 2000 : 10000;
  const Shadows without = shadowRays(*scene, {}, rays), with = shadowRays(*scene, learned(*scene), rays);
  EXPECT_NEAR(with.mean / without.mean, 1, 0.01);
  EXPECT_LT(with.variance, without.variance);
}

TEST(LightSampler, OneLightNeedsNone) {
  const auto scene = sceneFrom(litCorner(16));
  EXPECT_FALSE(learned(*scene).active());
}
