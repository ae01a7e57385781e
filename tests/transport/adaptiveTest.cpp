/** @file
 * Adaptive samples: the mean of every pixel is unbiased, even if bright samples are rare; samples are
 * concentrated where the error is large, and no pixel has too few; the result does not depend on threads and
 * interruptions.
 */
#include "rendering.h"

#include <functional>
#include <random>

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Integrator whose radiance is a function of the direction and random numbers, instead of a scene. */
class Formula final : public Integrator {
 public:
  using Radiance = std::function<float(const Vec3f& direction, Sampler& sampler)>;
  explicit Formula(Radiance radiance) : radiance(std::move(radiance)) {}
  void backward(const Scene&, const CameraRay& ray, Sampler& sampler, PathRadiance& out) const override {
    out.add(out.pathClasses().lightStart(), out.pathClasses().cameraStart(),
            Rgb(radiance(ray.direction, sampler)));
  }
  std::vector<EstimatorDomain> domains() const override { return {}; }

 private:
  Radiance radiance;
};

/** Random event from a hash of two random numbers, so that stratification has no effect. */
bool happens(float probability, Sampler& sampler) {
  const Vec2f u = sampler.next2D();
  return double(mixBits(uint64_t(u.x * 0x1p24f) << 32 | uint64_t(u.y * 0x1p24f))) * 0x1p-64 <
         double(probability);
}

/** Radiance with mean 1: constant on the left; on the right 1 / probability, with this probability. */
Formula::Radiance rareOnTheRight(float probability, float from = 0) {
  return [=](const Vec3f& direction, Sampler& sampler) {
    if (direction.x < from) return 1.0f;
    return happens(probability, sampler) ? 1 / probability : 0.0f;
  };
}

std::string emptyScene(int size) {
  return view(size, "0 0 0  0 0 1  0 1 0", 60) + "Shape \"sphere\" \"float radius\" .1\n";
}

struct State {
  Film film;
  SampleAllocation allocation;
  RenderPosition position;
};

struct Settings {
  int samples = 32;
  uint64_t seed = 1;
  bool adaptive = true;
  int threads = 0;
};

Rendered renderWith(const Scene& scene, Integrator& integrator, const Settings& s,
                    std::vector<State>* saved = nullptr, const State* from = nullptr) {
  const ThreadPool pool(s.threads);
  const PathClasses classes;
  Rendered out{Film(scene.film().crop, 1), {}};
  SampleAllocation allocation(scene.film().crop);
  RenderSettings settings;
  settings.samplesPerPixel = s.samples;
  settings.seed = s.seed;
  if (s.adaptive) settings.allocation = &allocation;
  if (from) {
    out.film = from->film;
    allocation = from->allocation;
    settings.from = from->position;
  }
  if (saved) {
    settings.saveInterval = 0;
    settings.save = [&](const RenderPosition& position) {
      saved->push_back({out.film, allocation, position});
    };
  }
  const std::atomic<bool> stop{false};
  out.statistics = render(scene, integrator, classes, settings, out.film, stop, nullptr, nullptr);
  return out;
}

Rendered renderWith(const Scene& scene, const Way& way, const Settings& s,
                    std::vector<State>* saved = nullptr, const State* from = nullptr) {
  const auto integrator = integratorFrom(way.integrator, way.parameters);
  return renderWith(scene, *integrator, s, saved, from);
}

bool same(const Rendered& a, const Rendered& b) {
  for (size_t p = 0; p < a.pixels(); ++p)
    if (a.film.samples(p) != b.film.samples(p) || a.value(p) != b.value(p)) return false;
  return true;
}

/** All ways, and one with fewer passes than samples. */
std::vector<Way> ways() {
  std::vector<Way> all = allWays("3000");
  all.push_back({"photonmap", "\"integer photons\" 1000 \"integer passes\" 5"});
  return all;
}

} // namespace

// If a pixel got more samples after a bright sample of its own, its mean would be far too dark.
TEST(Adaptive, RareBrightSamplesCountForWhatTheyAre) {
  constexpr float PROBABILITY = 0.04f;
  constexpr int SIZE = 24;
  const auto scene = sceneFrom(emptyScene(SIZE));
  std::vector<double> means, naive;
  uint64_t least = 1000, most = 0;
  for (uint64_t seed = 1; seed <= uint64_t(samples(400)); ++seed) {
    Formula formula(rareOnTheRight(PROBABILITY));
    const Rendered r = renderWith(*scene, formula, {.seed = seed});
    least = std::min(least, r.statistics.least);
    most = std::max(most, r.statistics.most);
    double sum = 0, naiveSum = 0;
    std::mt19937_64 random(seed);
    std::bernoulli_distribution bright{double(PROBABILITY)};
    int pixels = 0;
    for (size_t p = 0; p < r.pixels(); ++p) {
      if (p % SIZE < SIZE / 2) continue;
      ++pixels;
      sum += double(r.value(p).r);
      int met = 0, count = 0;
      const auto take = [&](int upTo) {
        for (; count < upTo; ++count) met += bright(random) ? 1 : 0;
      };
      take(8);
      take(met > 0 ? 64 : 12);
      naiveSum += double(met) / count / double(PROBABILITY);
    }
    means.push_back(sum / pixels);
    naive.push_back(naiveSum / pixels);
  }
  EXPECT_GE(least, 32u / 4);
  EXPECT_GT(most, 2 * least) << "the samples are not dealt out at all";
  const Mean mean(means), wrong(naive);
  EXPECT_LT(mean.error, 0.01);
  EXPECT_NEAR(mean.value, 1, 4 * mean.error);
  EXPECT_LT(wrong.value, 1 - 4 * wrong.error) << "this test would find no fault";
}

/** A class of pixels has a bright sample or two: a pixel must not get more samples than others after its own.
 */
TEST(Adaptive, TheOnlyBrightSampleOfManyPixelsCountsForWhatItIs) {
  const auto scene = sceneFrom(emptyScene(24));
  std::vector<double> means;
  for (uint64_t seed = 1; seed <= uint64_t(samples(400)); ++seed) {
    Formula formula(rareOnTheRight(0.001f, -1));
    means.push_back(renderWith(*scene, formula, {.seed = seed}).mean());
  }
  const Mean mean(means);
  EXPECT_LT(mean.error, SANITIZED ? 0.2 : 0.025);
  EXPECT_NEAR(mean.value, 1, 4 * mean.error);
}

TEST(Adaptive, SamplesGoWhereTheErrorIs) {
  const auto scene = sceneFrom(emptyScene(32));
  const auto squaredError = [](const Rendered& r) {
    double sum = 0;
    for (size_t p = 0; p < r.pixels(); ++p) sum += double(square(r.value(p).r - 1));
    return sum;
  };
  double adaptive = 0, even = 0;
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    Formula formula(rareOnTheRight(0.5f, 0.3f));
    const Rendered a = renderWith(*scene, formula, {.samples = 64, .seed = seed});
    const Rendered e = renderWith(*scene, formula, {.samples = 64, .seed = seed, .adaptive = false});
    adaptive += squaredError(a);
    even += squaredError(e);
    EXPECT_NEAR(double(a.statistics.samples), double(e.statistics.samples),
                0.002 * double(e.statistics.samples));
    EXPECT_EQ(a.statistics.stopReason, StopReason::SAMPLES);
    EXPECT_EQ(a.statistics.least, 64u / 4);
    EXPECT_LE(a.statistics.most, 8u * 64 + 16);
    EXPECT_EQ(e.statistics.least, 64u);
    EXPECT_EQ(e.statistics.most, 64u);
  }
  EXPECT_LT(adaptive, 0.5 * even);
}

// Isolated noisy pixels: neighbours show no variance, but the class of quiet pixels in the whole picture
// does.
TEST(Adaptive, QuietSurroundingsAreNotTrustedFurtherThanTheyDeserve) {
  constexpr int SIZE = 48;
  const auto scene = sceneFrom(emptyScene(SIZE));
  const auto isAlone = [](const Vec3f& d) {
    const Vec2f pixel = (Vec2f(d.x, d.y) / d.z / std::tan(glm::radians(30.0f)) + 1.0f) * (0.5f * SIZE);
    return int(pixel.x) % 6 == 3 && int(pixel.y) % 6 == 3;
  };
  Formula formula(
      [&](const Vec3f& d, Sampler& sampler) { return isAlone(d) ? 2 * float(happens(0.5f, sampler)) : 1; });
  const Rendered r = renderWith(*scene, formula, {.samples = 64});
  uint64_t alone = 0, count = 0;
  for (size_t p = 0; p < r.pixels(); ++p) {
    if (r.film.variance(p) == 0) continue;
    alone += r.film.samples(p);
    ++count;
  }
  EXPECT_NEAR(double(count), square(SIZE / 6.0), 1);
  EXPECT_GT(double(alone) / double(count), 64);
}

TEST(Adaptive, EdgesGetTheSamples) {
  const auto scene = sceneFrom(emptyScene(64));
  // A disc, and weak noise everywhere.
  Formula formula([](const Vec3f& d, Sampler& sampler) {
    return (square(d.x) + square(d.y) < 0.1f ? 2.0f : 1.0f) + 0.02f * float(happens(0.5f, sampler));
  });
  const Rendered truth = renderWith(*scene, formula, {.samples = samples(4096), .adaptive = false});
  double adaptive = 0, even = 0;
  for (uint64_t seed = 2; seed <= 5; ++seed) {
    const Rendered a = renderWith(*scene, formula, {.samples = 32, .seed = seed});
    const Rendered e = renderWith(*scene, formula, {.samples = 32, .seed = seed, .adaptive = false});
    for (size_t p = 0; p < a.pixels(); ++p) {
      adaptive += double(square(a.value(p).r - truth.value(p).r));
      even += double(square(e.value(p).r - truth.value(p).r));
    }
  }
  EXPECT_LT(adaptive, 0.6 * even);
}

TEST(Adaptive, OneBrightPixelDoesNotSwallowTheBudget) {
  const auto scene = sceneFrom(emptyScene(32));
  Formula formula([](const Vec3f& d, Sampler& sampler) {
    const float u = sampler.next1D();
    const bool brightPixel = std::abs(d.x - 0.2f) < 0.015f && std::abs(d.y - 0.2f) < 0.015f;
    return brightPixel && u < 0.2f ? 1e5f : 2 * u;
  });
  const Rendered r = renderWith(*scene, formula, {.samples = 64});
  EXPECT_LT(r.statistics.most, 2u * 64);
  EXPECT_GT(r.statistics.least, 32u);
}

TEST(Adaptive, NothingToTellMeansTheSameForAll) {
  const auto scene = sceneFrom(emptyScene(8));
  for (const float value : {0.0f, 3.0f}) {
    Formula formula([value](const Vec3f&, Sampler&) { return value; });
    for (const int count : {1, 5, 8, 9, 50}) {
      const Rendered r = renderWith(*scene, formula, {.samples = count});
      EXPECT_NEAR(double(r.statistics.samples), 64.0 * count, 16) << count;
      EXPECT_LT(r.statistics.most, uint64_t(count) + 4); // round numbers
      EXPECT_EQ(r.value(0).r, value);
    }
  }
}

TEST(Adaptive, SameBitsForAnyNumberOfThreads) {
  const auto scene = sceneFrom(litCorner(20));
  for (const Way& way : dealt(ways(), 0)) {
    const Rendered one = renderWith(*scene, way, {.samples = 25, .threads = 1});
    EXPECT_GT(one.statistics.most, one.statistics.least);
    EXPECT_TRUE(same(one, renderWith(*scene, way, {.samples = 25, .threads = 3}))) << way.parameters;
  }
}

TEST(Adaptive, GoesOnFromWhereverItWas) {
  const auto scene = sceneFrom(litCorner(20));
  for (const Way& way : dealt(ways(), 1)) {
    std::vector<State> saved;
    const Settings settings{.samples = 25};
    const Rendered whole = renderWith(*scene, way, settings, &saved);
    ASSERT_GT(saved.size(), 8u);
    for (size_t i = 0; i < saved.size(); i += std::max<size_t>(1, saved.size() / 6))
      EXPECT_TRUE(same(whole, renderWith(*scene, way, settings, nullptr, &saved[i])))
          << way.integrator << way.parameters << " from save " << i << " of " << saved.size();
  }
}

TEST(Adaptive, MeansAgreeWithThoseOfEvenSamples) {
  const auto scene = sceneFrom(litCorner(20));
  const int count = SANITIZED ? 100 : 200;
  for (const Way& way : dealt(ways(), 2)) {
    // One seed is enough: a single map of few photons has a standard error of 4 %.
    const Rendered a = renderWith(*scene, way, {.samples = count, .seed = 1});
    const Rendered b = renderWith(*scene, way, {.samples = count, .seed = 1, .adaptive = false});
    const double maps = way.integrator == "path" ? 0 : 0.02 * b.mean(); // numbers of passes may differ
    EXPECT_NEAR(a.mean(), b.mean(), 4 * std::hypot(a.standardError(), b.standardError()) + maps)
        << way.integrator << way.parameters;
  }
}
