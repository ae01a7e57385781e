/** @file
 * The walk of all estimators: densities of vertices are correct by geometry in both directions; a walk
 * follows its path class and ends at its limits; and the plain path tracer that uses it has the picture of
 * `path`.
 */
#include "rendering.h"

#include "transport/paths/walker.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** A closed matt room with `ball` in the middle and a small lamp that does not scatter. */
std::string room(const std::string& ball) {
  return view(8, "0 -.9 .2  0 0 0  0 0 1", 60) + R"(
Material "diffuse" "rgb reflectance" [ .5 .6 .7 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 1  1 -1 1  1 1 1  -1 1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 1 -1  1 1 -1  1 1 1  -1 1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  -1 1 -1  -1 1 1  -1 -1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ 1 -1 -1  1 1 -1  1 1 1  1 -1 1 ]
AttributeBegin
)" + ball +
         R"(
Shape "sphere" "float radius" .3
AttributeEnd
AttributeBegin
Material "interface"
AreaLightSource "diffuse" "rgb L" [ 9 8 7 ]
Translate .5 .3 .6
Shape "sphere" "float radius" .2
AttributeEnd
)";
}

const std::string MATT_BALL, GLASS_BALL = "Material \"dielectric\" \"float eta\" 1.5";

template <class State> Subpath<State> subpathFrom(const State& state, const Vec3f& direction) {
  Subpath<State> path;
  path.ray = {Vec3f(0, -.9f, .2f), glm::normalize(direction), INFINITE};
  path.from = path.ray.origin;
  path.state = state;
  return path;
}

/** Traces walks from inside of the room, and checks the densities of their vertices. */
template <class State> void expectDensitiesOfMattSurfaces(const Scene& scene, const State& state) {
  const PathClasses classes;
  TransportCounts counts;
  Walker<State> walker(scene, classes, counts, -1);
  int segments = 0, lamps = 0;
  for (uint32_t i = 0; i < 200; ++i) {
    Sampler sampler(1, 2, i);
    Subpath<State> path = subpathFrom(state, Vec3f(sampler.next2D() - 0.5f, sampler.next1D() - 0.5f));
    PathVertex<State> v;
    SurfacePoint before{};
    while (walker.next(path, v, sampler, [&](const Hit* hit) { lamps += hit != nullptr; })) {
      EXPECT_EQ(v.hit.areaLight, nullptr); // the lamp does not scatter
      const auto cosine = double(absDot(v.wi, v.point().geometricNormal));
      const auto distance2 = double(lengthSquared(v.point().position - path.from));
      if (v.depth == 1) { // the density of the first ray is 1/sr
        EXPECT_NEAR(v.pdf, cosine / distance2, 1e-5 * v.pdf);
      } else {
        const double pdf = double(absDot(v.wi, before.geometricNormal)) * cosine / (double(PI) * distance2);
        EXPECT_NEAR(v.pdf, pdf, 1e-4 * pdf);
        // The walk in the reverse direction has the same density for the previous vertex: both vertices are
        // matt.
        EXPECT_NEAR(v.pdfPrevious(v.point().normalTowards(v.wi)), pdf, 1e-4 * pdf);
        ++segments;
      }
      before = v.point();
      if (!walker.scatter(path, v, sampler)) break;
    }
  }
  EXPECT_GT(segments, 100);
  EXPECT_GT(lamps, 10);
}

} // namespace

TEST(Walker, DensitiesAreThoseOfTheGeometryFromEitherEnd) {
  const ThreadPool pool;
  const auto scene = sceneFrom(room(MATT_BALL));
  const PathClasses classes;
  expectDensitiesOfMattSurfaces(*scene, classes.cameraStart());
  expectDensitiesOfMattSurfaces(*scene, classes.lightStart());
}

TEST(Walker, ReadsClassesAndEndsWhereItIsToldTo) {
  const ThreadPool pool;
  const auto scene = sceneFrom(room(GLASS_BALL));
  const PathClasses classes(std::vector<PathClass>{{"glass", "LSSDE"}});
  TransportCounts counts;
  Walker<LightState> walker(*scene, classes, counts, 3);
  int lit = 0;
  for (uint32_t i = 0; i < 200; ++i) {
    Sampler sampler(1, 2, i);
    LightSubpath path =
        subpathFrom(classes.lightStart(), Vec3f(0.2f * (sampler.next2D() - 0.5f), 0) - Vec3f(0, -.9f, .2f));
    LightVertex v;
    while (walker.next(path, v, sampler)) {
      ASSERT_LE(v.depth, 3);
      EXPECT_EQ(v.allowed, v.depth < 3 ? DELTA_LOBES : NON_DELTA_LOBES);
      lit += v.depth == 3 && v.isConnectable();
      if (!walker.scatter(path, v, sampler)) break;
      if (v.depth < 3) {
        EXPECT_TRUE(path.delta);
        EXPECT_EQ(path.pdf, 1);
      }
    }
  }
  EXPECT_GT(lit, 100);
}

TEST(CameraRoulette, BeginsBelowHalfOfTheThroughputAndKeepsTheMean) {
  const auto survivors = [](float throughput, int length, float etaScale, float left) {
    int count = 0;
    constexpr int N = 20000;
    double sum = 0;
    for (uint32_t i = 0; i < N; ++i) {
      Sampler sampler(1, 0, i);
      Rgb t(throughput);
      if (!cameraRoulette(etaScale, length, sampler, t, left)) continue;
      ++count;
      sum += double(t.g);
    }
    EXPECT_NEAR(sum / N, double(throughput), 0.03 * double(throughput));
    return double(count) / N;
  };
  EXPECT_EQ(survivors(0.001f, 1, 1, 1), 1); // short paths always survive
  EXPECT_EQ(survivors(0.001f, 2, 1, 1), 1);
  EXPECT_EQ(survivors(0.5f, 3, 1, 1), 1);
  EXPECT_NEAR(survivors(0.1f, 3, 1, 1), 0.2, 0.01);
  EXPECT_NEAR(survivors(0.1f, 3, 2.25f, 1), 0.45, 0.01); // inside glass
  EXPECT_NEAR(survivors(0.8f, 3, 1, 0.25f), 0.4, 0.01);  // most of the light is left to photons
  EXPECT_EQ(survivors(0, 3, 1, 1), 0);
}

TEST(CameraRoulette, EndsLosslessPathsButNotSlowlyFadingOnes) {
  const auto lengthOf = [](float albedo, uint32_t i, float least) {
    Sampler sampler(2, 0, i);
    Rgb throughput(1);
    int length = 1;
    for (; length < 1'000'000 && maxComponent(throughput) >= least; ++length) {
      throughput *= albedo;
      if (!cameraRoulette(1, length, sampler, throughput)) break;
    }
    return length;
  };
  for (uint32_t i = 0; i < 20; ++i) {
    EXPECT_LT(lengthOf(1, i, 0), 1'000'000);
    EXPECT_GE(lengthOf(0.9999f, i, 0.5f), 6900); // attenuation to one half by absorption alone
  }
}

TEST(SimplePath, HasThePictureOfPath) {
  const std::string lights = R"(
LightSource "infinite" "rgb L" [ .3 .4 .5 ]
AttributeBegin
Translate 2 -2 3
LightSource "point" "rgb I" [ 4 4 4 ]
AttributeEnd
)";
  for (const std::string& text : {room(GLASS_BALL), litCorner(8) + lights}) {
    const Rendered path = renderText(text, "path", "", SANITIZED ? 64 : 1024);
    const Rendered plain = renderText(text, "simplepath", "", SANITIZED ? 64 : 1024, 2);
    const double error = std::hypot(path.standardError(), plain.standardError());
    EXPECT_NEAR(plain.mean(), path.mean(), 4 * error);
    EXPECT_LT(error, (SANITIZED ? 0.08 : 0.02) * path.mean());
  }
}

/** Sampling of lights or BSDFs alone has the same mean, with more noise. The standard error comes from
 * several pictures: samples of a pixel are stratified, so that their spread does not measure it. */
TEST(SimplePath, WithoutSamplingLightsOrBsdfsHasThePictureOfPath) {
  const std::string steel = "Material \"conductor\" \"float roughness\" .2 \"bool remaproughness\" false "
                            "\"rgb reflectance\" [.9 .8 .7]";
  const int n = SANITIZED ? 256 : 1024;
  for (const std::string& text : {room(GLASS_BALL), room(steel)}) {
    const Rendered path = renderText(text, "path", "", n);
    const auto noiseOf = [&](const std::string& parameters) {
      double sum = 0;
      for (uint64_t seed = 11; seed < 17; seed += 2) {
        const Rendered a = renderText(text, "simplepath", parameters, n, seed),
                       b = renderText(text, "simplepath", parameters, n, seed + 1);
        for (size_t i = 0; i < a.pixels(); ++i) sum += square(double(luminance(a.value(i) - b.value(i))));
      }
      return std::sqrt(sum);
    };
    const double plain = noiseOf("");
    for (const char* parameters : {"\"bool samplelights\" false", "\"bool samplebsdf\" false",
                                   "\"bool samplelights\" false \"bool samplebsdf\" false"}) {
      const Rendered chance = renderText(text, "simplepath", parameters, n, 2);
      EXPECT_NEAR(chance.mean(), path.mean(), 4 * std::hypot(path.standardError(), chance.standardError()))
          << parameters;
      EXPECT_GT(noiseOf(parameters), 1.1 * plain) << parameters;
    }
  }
}
