/** @file
 * Renders stop at the time limit or at an interrupt, even within a sample, and leave no bands.
 */
#include <limits>
#include <memory>
#include <thread>

#include "render/roundSchedule.h"
#include "rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

const char* const LIT_FLOOR = R"(
Film "rgb" "integer xresolution" 96 "integer yresolution" 96
LookAt 0 2 -4  0 0 0  0 1 0
Camera "perspective" "float fov" 50
WorldBegin
LightSource "infinite" "rgb L" [ 1 1 1 ]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 4 4 4 ]
Translate 0 2 0
Shape "sphere" "float radius" .3
AttributeEnd
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
Shape "bilinearmesh" "point3 P" [ -9 0 -9  9 0 -9  -9 0 9  9 0 9 ]
)";

/** Lossless scene: paths have a thousand vertices, and each is connected with each. */
const char* const WHITE_BALL = R"(
Film "rgb" "integer xresolution" 64 "integer yresolution" 64
Camera "perspective" "float fov" 50
WorldBegin
LightSource "point" "point3 from" [ 0 .5 0 ]
Material "diffuse" "rgb reflectance" [ 1 1 1 ]
Shape "sphere" "float radius" 1
)";

struct TimedRender {
  Film film;
  RenderStatistics statistics;
  double seconds = 0;
};

TimedRender renderTimed(const std::string& integrator, const std::string& parameters, RenderSettings settings,
                        const std::atomic<bool>& stop, const char* text = LIT_FLOOR) {
  const auto scene = sceneFrom(text);
  const auto made = integratorFrom(integrator, parameters);
  const PathClasses classes;
  TimedRender out{Film(scene->film().crop, 1), {}, 0};
  const auto start = std::chrono::steady_clock::now();
  out.statistics = render(*scene, *made, classes, settings, out.film, stop, {}, {});
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

/** Bound [s] of an immediate stop on any machine; without it the render would take minutes more. */
constexpr double AT_ONCE = 60;

// Integrators for which each sample of a pixel takes seconds, and a batch minutes.
const std::pair<const char*, const char*> SLOW[] = {
    {"path", "\"integer lightsamples\" 1000000"},
    {"photonmap", "\"integer photons\" 1000 \"integer lightsamples\" 1000000"},
    {"photonmap", "\"integer photons\" 1000 \"integer finalgather\" 100000"},
};

/** The first pass takes `first` seconds, as with learning, and each later pass `later`, unless it is
 * stopped. */
class SlowPasses : public Integrator {
 public:
  SlowPasses(double first, double later) : first(first), later(later) {}
  Passes passes(int) const override { return Passes::perSample(); }
  ForwardStatistics forward(const Scene&, const PathClasses&, const Pass& pass,
                            const ForwardControl& control) override {
    if (pass.index >= lastPass) stop = true;
    const auto end =
        std::chrono::steady_clock::now() + std::chrono::duration<double>(pass.index == 0 ? first : later);
    while (std::chrono::steady_clock::now() < end && !control.stopped())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return {};
  }
  void backward(const Scene&, const CameraRay&, Sampler&, PathRadiance&) const override {}
  std::vector<EstimatorDomain> domains() const override { return {}; }

  uint32_t lastPass = std::numeric_limits<uint32_t>::max(); ///< the pass that sets `stop`
  std::atomic<bool> stop{false};

 private:
  double first, later;
};

RenderStatistics renderSlowPasses(SlowPasses& integrator, double limit) {
  const auto scene = sceneFrom(LIT_FLOOR);
  RenderSettings settings;
  settings.samplesPerPixel = 0;
  settings.timeLimit = limit;
  Film film(scene->film().crop, 1);
  return render(*scene, integrator, PathClasses(), settings, film, integrator.stop, {}, {});
}

/** Path tracing that interrupts the render at its n-th camera path. */
class StoppingPaths : public Integrator {
 public:
  explicit StoppingPaths(int64_t count) : paths(integratorFrom("path", "")), left(count) {}
  TransportCounts prepare(const Scene& scene, const PathClasses& classes) override {
    return paths->prepare(scene, classes);
  }
  Passes passes(int samplesPerPixel) const override { return paths->passes(samplesPerPixel); }
  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override {
    return paths->forward(scene, classes, pass, control);
  }
  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    if (--left == 0) stop = true;
    paths->backward(scene, ray, sampler, out);
  }
  std::vector<EstimatorDomain> domains() const override { return paths->domains(); }

  mutable std::atomic<bool> stop{false};

 private:
  std::unique_ptr<Integrator> paths;
  mutable std::atomic<int64_t> left;
};

/** The first pass learns for ten minutes without checking for a stop. */
class SlowLearner : public Integrator {
 public:
  ForwardStatistics forward(const Scene&, const PathClasses&, const Pass&, const ForwardControl&) override {
    for (int i = 0; i < 600; ++i)
      parallelFor(1000 * size_t(threadCount()),
                  [](size_t) { std::this_thread::sleep_for(std::chrono::milliseconds(1)); });
    return {};
  }
  void backward(const Scene&, const CameraRay&, Sampler&, PathRadiance&) const override {}
  std::vector<EstimatorDomain> domains() const override { return {}; }
};

/** Camera paths trace rays without end; the first one interrupts the render. */
class EndlessRays : public Integrator {
 public:
  Passes passes(int) const override { return Passes::oneMap(); }
  ForwardStatistics forward(const Scene&, const PathClasses&, const Pass&, const ForwardControl&) override {
    return {};
  }
  void backward(const Scene& scene, const CameraRay& ray, Sampler&, PathRadiance&) const override {
    stop = true;
    Hit hit;
    for (int64_t rays = 0; rays < MANY; ++rays) scene.intersect(ray, hit);
    ++pathsToTheEnd;
  }
  std::vector<EstimatorDomain> domains() const override { return {}; }

  mutable std::atomic<bool> stop{false};
  mutable std::atomic<int> pathsToTheEnd{0};

 private:
  static constexpr int64_t MANY = 1'000'000'000; // takes minutes on any machine
};

} // namespace

// If the first pass were the estimate for later ones, none would start in the remaining time.
TEST(TimeLimit, IsUsedAfterAFirstPassThatTookMostOfIt) {
  SlowPasses integrator(3, 0.001);
  integrator.lastPass = 3;
  const RenderStatistics s = renderSlowPasses(integrator, 5.9);
  EXPECT_EQ(s.passes, 3);
  EXPECT_EQ(s.stopReason, StopReason::INTERRUPTED);
}

TEST(TimeLimit, EndsPassesThatTakeLongerThanTheFirst) {
  SlowPasses integrator(0.01, 600);
  const RenderStatistics s = renderSlowPasses(integrator, 1);
  EXPECT_LT(s.renderSeconds, AT_ONCE);
  EXPECT_EQ(s.least, 1u);
  EXPECT_EQ(s.most, 1u);
  EXPECT_EQ(s.stopReason, StopReason::TIME);
}

TEST(TimeLimit, EndsLearningWithoutASampleWhereThatIsWanted) {
  const auto scene = sceneFrom(LIT_FLOOR);
  for (const bool isStopped : {false, true}) {
    SlowLearner integrator;
    std::atomic<bool> stop{false};
    std::jthread later([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      if (isStopped) stop = true;
    });
    RenderSettings settings;
    settings.timeLimit = isStopped ? 0 : 0.2;
    settings.limitsFirstPass = true;
    Film film(scene->film().crop, 1);
    const RenderStatistics s = render(*scene, integrator, PathClasses(), settings, film, stop, {}, {});
    EXPECT_LT(s.renderSeconds, AT_ONCE);
    EXPECT_EQ(s.samples, 0u);
    EXPECT_EQ(s.stopReason, isStopped ? StopReason::INTERRUPTED : StopReason::TIME);
  }
}

TEST(TimeLimit, MayEndTheLearningOfEachIntegrator) {
  const std::atomic<bool> stop{false};
  for (const char* integrator : {"path", "photonmap", "auto", "bdpt", "vcm"}) {
    RenderSettings settings;
    settings.samplesPerPixel = 4;
    settings.timeLimit = 1e-9;
    const TimedRender r = renderTimed(integrator, "", settings, stop);
    EXPECT_EQ(r.statistics.stopReason, StopReason::TIME) << integrator;
  }
}

TEST(TimeLimit, IsKeptWithinASample) {
  const std::atomic<bool> stop{false};
  for (const auto& [integrator, parameters] : SLOW) {
    RenderSettings settings;
    settings.samplesPerPixel = 0;
    settings.timeLimit = 0.3;
    settings.firstSampleTime = 0.2;
    const TimedRender r = renderTimed(integrator, parameters, settings, stop);
    EXPECT_LT(r.seconds, AT_ONCE) << parameters;
    EXPECT_EQ(r.statistics.stopReason, StopReason::TIME);
  }
}

TEST(TimeLimit, StopIsKeptWithinASample) {
  for (const auto& [integrator, parameters] : SLOW) {
    std::atomic<bool> stop{false};
    std::jthread later([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      stop = true;
    });
    RenderSettings settings;
    settings.samplesPerPixel = 4;
    const TimedRender r = renderTimed(integrator, parameters, settings, stop);
    EXPECT_LT(r.seconds, AT_ONCE) << parameters;
    EXPECT_EQ(r.statistics.stopReason, StopReason::INTERRUPTED);
  }
}

TEST(TimeLimit, EndsConnectionsWithinASample) {
  for (const auto& [integrator, parameters] :
       {std::pair("bdpt", "\"integer lightpaths\" 100"), std::pair("vcm", "\"integer photons\" 100")})
    for (const bool isStopped : {false, true}) {
      std::atomic<bool> stop{false};
      std::jthread later([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        stop = isStopped;
      });
      RenderSettings settings;
      settings.samplesPerPixel = 4;
      settings.timeLimit = isStopped ? 0 : 0.3;
      settings.firstSampleTime = 0.2;
      const TimedRender r = renderTimed(integrator, parameters, settings, stop, WHITE_BALL);
      EXPECT_LT(r.seconds, AT_ONCE) << integrator;
      EXPECT_EQ(r.statistics.stopReason, isStopped ? StopReason::INTERRUPTED : StopReason::TIME);
    }
}

// An interrupted round leaves half of the pixels with fewer samples. This happens if the machine suspends the
// process for long, but not each time; renders with few samples, or with so short rounds that they hide it,
// are not counted.
TEST(TimeLimit, LeavesPixelsWithEquallyManySamples) {
  const std::atomic<bool> stop{false};
  int renders = 0, even = 0;
  double limit = 0.4;
  for (int i = 0; i < 30 && renders < 10 && even < 3; ++i) {
    RenderSettings settings;
    settings.samplesPerPixel = 0;
    settings.timeLimit = limit;
    const TimedRender r = renderTimed("path", "", settings, stop);
    EXPECT_EQ(r.statistics.stopReason, StopReason::TIME);
    EXPECT_GE(r.statistics.least, 1u);
    EXPECT_GT(r.seconds, 0.3 * limit);
    EXPECT_LT(r.seconds, limit + AT_ONCE);
    if (r.statistics.most < 32) {
      limit *= 2;
    } else if (r.statistics.most > 192) {
      limit /= 2;
    } else {
      ++renders;
      even += double(r.statistics.least) >= 0.75 * double(r.statistics.most) ? 1 : 0;
    }
  }
  EXPECT_EQ(even, 3) << "of " << renders;
}

/** An interrupted round is rendered again: the picture has the same bits. */
TEST(TimeLimit, RendersThatWereStoppedGoOnWithTheSamePicture) {
  const auto scene = sceneFrom(LIT_FLOOR);
  const PathClasses classes;
  for (const bool adaptive : {false, true}) {
    int stops = 0;
    const auto renderIn = [&](int64_t paths) { // initial number of paths between stops
      Film film(scene->film().crop, 1);
      std::optional<SampleAllocation> allocation;
      if (adaptive) allocation.emplace(film.bounds());
      RenderSettings settings;
      settings.samplesPerPixel = 32;
      settings.allocation = allocation ? &*allocation : nullptr;
      RenderPosition kept;
      settings.save = [&](const RenderPosition& position) { kept = position; };
      for (;; paths += paths / 4) {
        settings.from = kept;
        StoppingPaths made(paths);
        const RenderStatistics s = render(*scene, made, classes, settings, film, made.stop, {}, {});
        if (s.stopReason == StopReason::SAMPLES) return film;
        ++stops;
      }
    };
    const Film once = renderIn(std::numeric_limits<int64_t>::max());
    EXPECT_EQ(stops, 0);
    const Film pieces = renderIn(1000);
    EXPECT_GT(stops, 4);
    for (size_t p = 0; p < once.bounds().area(); ++p) {
      ASSERT_EQ(once.samples(p), pieces.samples(p)) << p << adaptive;
      ASSERT_EQ(once.value(p, 0), pieces.value(p, 0)) << p << adaptive;
    }
  }
}

TEST(TimeLimit, StopIsKeptBetweenRaysOfOneCameraPath) {
  const auto scene = sceneFrom(LIT_FLOOR);
  EndlessRays integrator;
  RenderSettings settings;
  settings.samplesPerPixel = 1;
  Film film(scene->film().crop, 1);
  const RenderStatistics s =
      render(*scene, integrator, PathClasses(), settings, film, integrator.stop, {}, {});
  EXPECT_EQ(integrator.pathsToTheEnd, 0);
  EXPECT_EQ(s.samples, 0u);
  EXPECT_EQ(s.stopReason, StopReason::INTERRUPTED);
}

TEST(TimeLimit, TheFirstSampleGoesFromCoarseToFine) {
  const auto scene = sceneFrom(LIT_FLOOR);
  Film film(scene->film().crop, 1);
  const auto width = size_t(film.bounds().width());
  const auto stageOf = [&](size_t p) { return CoarseToFine::stageOf(int(p % width), int(p / width)); };
  int64_t coarse = 0;
  for (size_t p = 0; p < film.bounds().area(); ++p) coarse += stageOf(p) == 0 ? 1 : 0;
  StoppingPaths integrator(coarse + 1);
  RenderSettings settings;
  settings.samplesPerPixel = 1;
  settings.timeLimit = 3600;
  const RenderStatistics s =
      render(*scene, integrator, PathClasses(), settings, film, integrator.stop, {}, {});
  EXPECT_EQ(s.stopReason, StopReason::INTERRUPTED);
  const std::vector<size_t> nearest = film.nearestSampled(FIRST_SAMPLE_REACH);
  ASSERT_EQ(nearest.size(), film.bounds().area());
  for (size_t p = 0; p < nearest.size(); ++p) {
    EXPECT_GT(film.samples(nearest[p]), 0u) << p;
    if (stageOf(p) == 0) {
      EXPECT_EQ(film.samples(p), 1u) << p;
    }
    if (stageOf(p) == 2) {
      EXPECT_EQ(film.samples(p), 0u) << p;
    }
  }
}

TEST(TimeLimit, PixelsWithoutASampleShowTheNearestThatHasOne) {
  Film film({0, 0, 5, 3}, 1);
  EXPECT_EQ(film.nearestSampled(1)[7], 7u); // no pixel has a sample
  const Rgb white(1);
  film.add(6, 0, 1, &white, white);
  EXPECT_EQ(film.nearestSampled(2), (std::vector<size_t>{6, 6, 6, 3, 4, 6, 6, 6, 6, 9, 6, 6, 6, 13, 14}));
  for (size_t p = 0; p < film.bounds().area(); ++p) film.add(p, 1, 1, &white, white);
  EXPECT_TRUE(film.nearestSampled(2).empty());
}

TEST(TimeLimit, TexturesAreAsSharpAsWithTheScenesNumberOfSamples) {
  // White and black meet between pixels 7 and 8; a filter of a pixel's width would carry 1/8 across.
  const auto scene = sceneFrom(R"(
Film "rgb" "integer xresolution" 16 "integer yresolution" 4
PixelFilter "box"
Sampler "independent" "integer pixelsamples" 64
LookAt 0 0 -1  0 0 0  0 1 0
Camera "orthographic" "float screenwindow" [ -1 1 -.25 .25 ]
WorldBegin
LightSource "infinite" "rgb L" [ 1 1 1 ]
Texture "halves" "spectrum" "checkerboard" "float uscale" 2 "rgb tex1" [ .8 .8 .8 ] "rgb tex2" [ 0 0 0 ]
Material "diffuse" "texture reflectance" "halves"
Shape "bilinearmesh" "point3 P" [ -1 -9 0  1 -9 0  -1 9 0  1 9 0 ] "point2 uv" [ 0 .1  1 .1  0 .2  1 .2 ]
)");
  const auto path = integratorFrom("path", "");
  Film film(scene->film().crop, 1);
  RenderSettings settings;
  settings.samplesPerPixel = 0;
  settings.timeLimit = 600;
  std::atomic<bool> stop{false};
  const auto progress = [&](const RenderProgress& p) { stop = stop || p.samplesPerPixel >= 64; };
  render(*scene, *path, PathClasses(), settings, film, stop, progress, {});
  ASSERT_GE(film.samples(0), 32u);
  const float left = film.value(7, 0).r, right = film.value(8, 0).r;
  const auto [dark, bright] = std::minmax(left, right);
  EXPECT_NEAR(bright, 0.8, 0.1);
  EXPECT_LT(dark, 0.04 * bright);
}

TEST(TimeLimit, EndsWhatIsLearnedOfLights) {
  // Each ray intersects many lamps, and learning takes 18,000 rays before the first sample.
  std::string text = R"(
Film "rgb" "integer xresolution" 96 "integer yresolution" 96
LookAt 0 0 -5  0 0 0  0 1 0
Camera "perspective"
WorldBegin
Material "diffuse"
ObjectBegin "0" AreaLightSource "diffuse" Shape "sphere" ObjectEnd
)";
  constexpr int DOUBLINGS = 13;
  for (int i = 0; i < DOUBLINGS; ++i) {
    const std::string below = "ObjectInstance \"" + std::to_string(i) + "\" ";
    text += "ObjectBegin \"" + std::to_string(i + 1) + "\" " + below + below + "ObjectEnd\n";
  }
  text += "ObjectInstance \"" + std::to_string(DOUBLINGS) + "\"\n";
  const auto scene = sceneFrom(text);
  const auto integrator = integratorFrom("path", "\"integer maxdepth\" 1");
  for (const bool isStopped : {false, true}) {
    std::atomic<bool> stop{false};
    std::jthread later([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      stop = isStopped;
    });
    RenderSettings settings;
    settings.samplesPerPixel = 0;
    settings.timeLimit = isStopped ? 0 : 0.2;
    settings.firstSampleTime = 0.2;
    Film film(scene->film().crop, 1);
    const auto start = std::chrono::steady_clock::now();
    const RenderStatistics s = render(*scene, *integrator, PathClasses(), settings, film, stop, {}, {});
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), AT_ONCE);
    EXPECT_EQ(s.stopReason, isStopped ? StopReason::INTERRUPTED : StopReason::TIME);
  }
}
