/** @file
 * Densities of the guide: normalisation, sampling, determinism, and the cells that use it.
 */
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "recurse/core/sampling/equalAreaSquare.h"
#include "recurse/core/sampling/sampling.h"
#include "recurse/core/threads/parallel.h"
#include "transport/guiding/guideField.h"

using namespace recurse;

namespace {

/** Points around a few random centres, with very different widths and weights. */
std::vector<WeightedPoint> randomPoints(uint32_t seed, size_t count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::normal_distribution<float> normal;
  std::array<Vec3f, 5> lobes;
  for (Vec3f& lobe : lobes) lobe = {uniform(random), uniform(random), std::exp2(-8 * uniform(random))};
  std::vector<WeightedPoint> points(count);
  for (size_t i = 0; i < count; ++i) {
    const Vec3f& lobe = lobes[i % lobes.size()];
    points[i].point = glm::clamp(Vec2f(lobe) + 0.1f * lobe.z * Vec2f(normal(random), normal(random)),
                                 Vec2f(0), Vec2f(0.9999999f));
    points[i].weight = std::exp(normal(random));
  }
  return points;
}

SquareTree randomTree(uint32_t seed, size_t count) {
  std::vector<WeightedPoint> points = randomPoints(seed, count);
  return SquareTree(points);
}

double integral(const SquareTree& tree, int across = 1024) {
  double sum = 0;
  for (int y = 0; y < across; ++y)
    for (int x = 0; x < across; ++x)
      sum += double(tree.pdf(Vec2f((float(x) + 0.5f) / float(across), (float(y) + 0.5f) / float(across))));
  return sum / (double(across) * across);
}

/** Integral of a density over all directions. */
double integral(const GuideCell& cell) {
  constexpr int ACROSS = 512;
  double sum = 0;
  for (int y = 0; y < ACROSS; ++y)
    for (int x = 0; x < ACROSS; ++x)
      sum +=
          double(cell.pdf(directionOfSquare(Vec2f((float(x) + 0.5f) / ACROSS, (float(y) + 0.5f) / ACROSS))));
  return sum * 4 * double(PI) / square(double(ACROSS));
}

/** Records of camera paths over a floor of unit size, whose directions follow a cosine lobe around +z. */
template <class Value> std::vector<GuideRecord> cosineRecords(size_t count, const Value& value) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<GuideRecord> records;
  for (size_t i = 0; i < count; ++i) {
    GuideRecord r;
    r.position = {uniform(random), uniform(random), 0};
    r.normal = {0, 0, 1};
    r.direction = cosineHemisphere({uniform(random), uniform(random)});
    r.value = value(r.direction) / (r.direction.z * INV_PI);
    if (r.value > 0) records.push_back(r);
  }
  return records;
}

const GuideCell* cellOf(const std::vector<GuideRecord>& records, GuideField& field) {
  field.build(records, 10);
  return field.find({0.5f, 0.5f, 0}, {0, 0, 1});
}

} // namespace

TEST(EqualAreaSquare, IsItsOwnInverse) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int i = 0; i < 10000; ++i) {
    const Vec3f d = uniformSphere({uniform(random), uniform(random)});
    EXPECT_GT(glm::dot(directionOfSquare(squareOfDirection(d)), d), 1 - 1e-6f);
  }
}

TEST(Sampling, TheSquareOfADiskIsTheInverseOfTheConcentricMap) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int i = 0; i < 10000; ++i) {
    const Vec2f u(uniform(random), uniform(random));
    EXPECT_LT(glm::length(squareOfDisk(uniformDisk(u)) - u), 1e-6f);
  }
  for (const Vec2f& d : {Vec2f(0), Vec2f(1, 0), Vec2f(0, -1), Vec2f(-0.70710678f, 0.70710678f)}) {
    const Vec2f u = squareOfDisk(d);
    EXPECT_TRUE(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1);
    EXPECT_LT(glm::length(uniformDisk(u) - d), 1e-6f);
  }
}

TEST(SquareTree, IntegratesToOne) {
  for (uint32_t seed = 0; seed < 2; ++seed) EXPECT_NEAR(integral(randomTree(seed, 20000)), 1, 1e-6);
}

TEST(SquareTree, OnePointMakesALeafOfTheLastDepth) {
  std::vector<WeightedPoint> points(1000, {{0.3f, 0.7f}, 1});
  const SquareTree tree(points);
  const double whole = std::pow(4.0, SquareTree::MAX_DEPTH);
  EXPECT_NEAR(double(tree.pdf(Vec2f(0.3f, 0.7f))), whole, 0.8 * whole);
}

TEST(SquareTree, PointsWithoutWeightLeaveItUniform) {
  std::vector<WeightedPoint> points(100);
  EXPECT_EQ(SquareTree(points).pdf({0.4f, 0.1f}), 1);
}

TEST(SquareTree, AFewStrongPointsDoNotDivideIt) {
  std::vector<WeightedPoint> points = randomPoints(3, 2000);
  for (WeightedPoint& p : points) p.weight = 1;
  for (size_t i = 0; i < 8; ++i) points[i].weight = 1e6f;
  EXPECT_EQ(SquareTree(points).nodeCount(), 1u);
}

TEST(SquareTree, SamplesHaveTheDensityThatTheySay) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (uint32_t seed = 0; seed < 10; ++seed) {
    const SquareTree tree = randomTree(seed, 3000);
    for (int i = 0; i < 2000; ++i) {
      float density = 0;
      const Vec2f p = tree.sample({uniform(random), uniform(random)}, density);
      EXPECT_TRUE(p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1);
      // Rounding moves a few points beyond the border of a leaf.
      const Vec2f grid = p * 1024.0f;
      if (glm::all(glm::greaterThan(glm::abs(grid - glm::round(grid)), Vec2f(0.01f)))) {
        EXPECT_NEAR(tree.pdf(p) / density, 1, 1e-5f);
      }
    }
  }
}

TEST(SquareTree, SamplesFollowTheDensityByAChiSquareTest) {
  constexpr int ACROSS = 32, SAMPLES = 50000;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (uint32_t seed = 0; seed < 5; ++seed) {
    const SquareTree tree = randomTree(seed, 2000);
    std::vector<double> expected(ACROSS * ACROSS), found(ACROSS * ACROSS);
    constexpr int FINE = 1024, STEP = FINE / ACROSS;
    for (int y = 0; y < FINE; ++y)
      for (int x = 0; x < FINE; ++x)
        expected[size_t(y / STEP * ACROSS + x / STEP)] +=
            SAMPLES / (double(FINE) * FINE) *
            double(tree.pdf(Vec2f((float(x) + 0.5f) / FINE, (float(y) + 0.5f) / FINE)));
    for (int i = 0; i < SAMPLES; ++i) {
      float density = 0;
      const Vec2f square = tree.sample({uniform(random), uniform(random)}, density);
      ++found[size_t(std::min(int(square.y * ACROSS), ACROSS - 1) * ACROSS +
                     std::min(int(square.x * ACROSS), ACROSS - 1))];
    }
    double chi2 = 0, restExpected = 0, restFound = 0;
    int degrees = 0;
    for (size_t i = 0; i < expected.size(); ++i) {
      restExpected += expected[i];
      restFound += found[i];
      if (restExpected < 5) continue;
      chi2 += square(restFound - restExpected) / restExpected;
      ++degrees;
      restExpected = restFound = 0;
    }
    // Wilson and Hilferty: the cube root is nearly normal.
    const double k = degrees - 1, normal = (std::cbrt(chi2 / k) - (1 - 2 / (9 * k))) / std::sqrt(2 / (9 * k));
    EXPECT_LT(normal, 4.5) << "tree " << seed;
  }
}

TEST(SquareTree, TheWarpIsMonotoneInEachNumber) {
  const SquareTree tree = randomTree(2, 5000);
  float density = 0, before = -1;
  for (int i = 0; i < 4096; ++i) {
    const float x = tree.sample({(float(i) + 0.5f) / 4096, 0.37f}, density).x;
    EXPECT_GE(x, before - 1e-6f);
    before = x;
  }
}

TEST(GuideField, IsTheSameForAnyNumberOfThreads) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<GuideRecord> records(30000);
  for (GuideRecord& r : records) {
    r.position = {uniform(random), uniform(random), uniform(random)};
    r.direction = uniformSphere({uniform(random), uniform(random)});
    r.normal = glm::normalize(r.position - 0.5f);
    r.value = uniform(random);
  }
  const auto densities = [&](int threads) {
    const ThreadPool pool(threads);
    GuideField field;
    field.build(records, 0.01f);
    std::vector<float> out{float(field.cellCount())};
    for (int i = 0; i < 500; ++i) {
      const GuideRecord& r = records[size_t(i)];
      const GuideCell* cell = field.find(r.position, r.normal);
      out.push_back(cell ? cell->pdf(records[size_t(i) + 1].direction) : -1);
    }
    return out;
  };
  const std::vector<float> one = densities(1);
  EXPECT_GT(one[0], 10);
  EXPECT_EQ(one, densities(3));
  EXPECT_EQ(one, densities(16));
}

TEST(GuideField, ADensityOfACellIntegratesToOneAndIsThatOfItsSamples) {
  GuideField field;
  const GuideCell* cell =
      cellOf(cosineRecords(20000, [](const Vec3f& d) { return d.x > 0.5f ? d.z : 0; }), field);
  ASSERT_NE(cell, nullptr);
  EXPECT_NEAR(integral(*cell), 1, 3e-3);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0, 1);
  int equal = 0;
  for (int i = 0; i < 1000; ++i) {
    float density = 0;
    const Vec3f d = cell->sample({uniform(random), uniform(random)}, density);
    equal += std::abs(cell->pdf(d) / density - 1) <
             1e-3f; // a few directions are beyond the border of a leaf by rounding
  }
  EXPECT_GT(equal, 990);
}

TEST(GuideField, InAMediumACellCoversAllDirections) {
  // Light from two opposite cones, in a medium that scatters evenly.
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<GuideRecord> records;
  for (int i = 0; i < 20000; ++i) {
    GuideRecord r;
    r.position = {uniform(random), uniform(random), uniform(random)};
    r.direction = uniformSphere({uniform(random), uniform(random)});
    r.value = std::abs(r.direction.z) > 0.8f ? 1 : 0.01f;
    records.push_back(r);
  }
  GuideField field;
  field.build(records, 10);
  const Vec3f middle(0.5f);
  EXPECT_EQ(field.find(middle, {0, 0, 1}), nullptr) << "surfaces learn nothing from media";
  const GuideCell* cell = field.find(middle, Vec3f(0));
  ASSERT_NE(cell, nullptr);
  EXPECT_NEAR(integral(*cell), 1, 3e-3);
  int inCones = 0, equal = 0;
  constexpr int SAMPLES = 10000;
  for (int i = 0; i < SAMPLES; ++i) {
    float density = 0;
    const Vec3f d = cell->sample({uniform(random), uniform(random)}, density);
    inCones += std::abs(d.z) > 0.8f;
    equal += std::abs(cell->pdf(d) / density - 1) < 1e-3f;
  }
  EXPECT_GT(equal, 99 * SAMPLES / 100);
  // A fifth of the sphere has 96 % of the light; leaves of the tree extend beyond it.
  EXPECT_GT(inCones, 8 * SAMPLES / 10);
}

TEST(GuideField, AnEvenSkyIsLearnedAsCosineSampling) {
  GuideField field;
  const GuideCell* cell = cellOf(cosineRecords(2000, [](const Vec3f& d) { return d.z; }), field);
  ASSERT_NE(cell, nullptr);
  EXPECT_NEAR(cell->pdf({0, 0, 1}), INV_PI, 0.2f * INV_PI);
  const LearnedDirections learned = field.learnedAt({0.5f, 0.5f, 0}, {0, 0, 1});
  EXPECT_EQ(learned.guide, cell);
  EXPECT_EQ(learned.records, 2000u);
  const GuideStatistics statistics = field.statistics();
  EXPECT_EQ(statistics.cells, field.cellCount() - 6) << "six roots without records";
  EXPECT_EQ(statistics.cellsOn, statistics.cells);
  EXPECT_EQ(statistics.records, 2000u);
}

TEST(GuideField, AWindowsLightHasHardlyMoreVarianceThanByAPerfectGuide) {
  // A floor below a uniform sky in a window that covers the fraction F of the cosine: cosine sampling has the
  // relative variance 1/F - 1, a perfect guide that is followed with probability 1 - a has a (1 - F) / (1 - a
  // + a F).
  const auto window = [](const Vec3f& d) {
    return d.x > 0.5f && std::abs(d.y) < 0.3f ? std::max(d.z, 0.0f) : 0.0f;
  };
  GuideField field;
  const GuideCell* cell = cellOf(cosineRecords(20000, window), field);
  ASSERT_NE(cell, nullptr);
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(0, 1);
  constexpr int SAMPLES = 100000;
  double mean = 0, moment = 0, cosine = 0;
  for (int i = 0; i < SAMPLES; ++i) {
    const float a = cell->bsdfProbability();
    float density = 0;
    const Vec2f u(uniform(random), uniform(random));
    const Vec3f d = uniform(random) < a ? cosineHemisphere(u) : cell->sample(u, density);
    const float byBsdf = std::max(d.z, 0.0f) * INV_PI;
    const double x = double(window(d) / (a * byBsdf + (1 - a) * cell->pdf(d)));
    mean += x / SAMPLES;
    moment += x * x / SAMPLES;
    cosine += double(window(cosineHemisphere({uniform(random), uniform(random)}))) > 0 ? 1.0 / SAMPLES : 0;
  }
  EXPECT_NEAR(mean, double(PI) * cosine, 0.02 * mean);
  const double a = double(cell->bsdfProbability()), perfect = a * (1 - cosine) / (1 - a + a * cosine);
  EXPECT_LT(moment / square(mean) - 1, 1.75 * perfect);
}

TEST(GuideField, FewRecordsAreNoGuide) {
  GuideField field;
  EXPECT_EQ(cellOf(cosineRecords(20, [](const Vec3f& d) { return d.x > 0.9f ? 1.0f : 0.01f; }), field),
            nullptr);
  EXPECT_EQ(cellOf({}, field), nullptr);
}

TEST(GuideField, OneStrongRecordDoesNotOwnACell) {
  std::vector<GuideRecord> records = cosineRecords(2000, [](const Vec3f& d) { return d.x > 0 ? d.z : 0; });
  records[10].value = 1e6f;
  GuideField field;
  const GuideCell* cell = cellOf(records, field);
  ASSERT_NE(cell, nullptr);
  EXPECT_LT(cell->pdf(records[10].direction), 20 * cell->pdf(glm::normalize(Vec3f(0.6f, 0, 0.8f))));
}

TEST(GuideField, PhotonsAndCameraPathsAreBroughtToOneScale) {
  // Photons arrive from x < 0, and camera paths find light from x > 0, in units that are a million times
  // smaller.
  std::vector<GuideRecord> records = cosineRecords(400, [](const Vec3f& d) { return d.z; });
  for (GuideRecord& r : records) {
    r.fromPhoton = r.direction.x < 0;
    r.value = r.fromPhoton ? 1e3f : 1e-3f;
  }
  GuideField field;
  // Without this gap the density is so close to BSDF sampling that the guide is switched off.
  std::erase_if(records, [](const GuideRecord& r) { return std::abs(r.direction.y) > 0.3f; });
  const GuideCell* cell = cellOf(records, field);
  ASSERT_NE(cell, nullptr);
  const auto massOf = [&](float sign) {
    double mass = 0;
    constexpr int ACROSS = 256;
    for (int y = 0; y < ACROSS; ++y)
      for (int x = 0; x < ACROSS; ++x) {
        const Vec3f d = cosineHemisphere({(float(x) + 0.5f) / ACROSS, (float(y) + 0.5f) / ACROSS});
        if (d.x * sign > 0) mass += double(cell->pdf(d) / (d.z * INV_PI)) / square(double(ACROSS));
      }
    return mass;
  };
  EXPECT_NEAR(massOf(-1), 0.5, 0.1);
  EXPECT_NEAR(massOf(1), 0.5, 0.1);
}
