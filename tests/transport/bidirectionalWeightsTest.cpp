/** @file
 * Weights of bidirectional techniques on random paths: they are equal to the number of samples times the
 * density of each technique over the sum for all, by explicit products, and add up to one, for any set of
 * enabled techniques.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "transport/weights/bidirectionalWeights.h"

using namespace recurse;

namespace {

/** Random path that at least one technique can sample, with random parameters. */
struct RandomPath {
  std::vector<WeightedVertex> x;
  WeightedPath path;
  size_t panes = 0;       ///< number of panes before the light
  double lightPdf = 0;    ///< density of shadow rays, in the measure of the light's end
  double straightWay = 1; ///< ratio of densities: a walk through the panes over the straight line

  explicit RandomPath(std::mt19937& random, size_t edges) : x(edges + 1) {
    const auto chance = [&] { return std::bernoulli_distribution(0.5)(random); };
    const auto density = [&] { return std::exp(std::normal_distribution<double>(0, 3)(random)); };
    for (WeightedVertex& v : x) {
      v.fromCamera = density();
      v.fromLight = density();
    }
    for (size_t i = 1; i < edges; ++i) x[i].delta = std::bernoulli_distribution(0.3)(random);
    if (edges > 1 && x[edges - 1].delta) panes = std::uniform_int_distribution<size_t>(0, edges - 1)(random);
    path.vertices = x;
    path.light = LightGeometry(std::uniform_int_distribution<int>(0, 2)(random));
    path.splats = chance() ? 1000 : 0;
    path.connections = chance() ? 1 : 0;
    if (chance()) lightPdf = density();
    path.shadowRays = edges > 1 && x[edges - 1].delta ? 0 : lightPdf;
    if (panes > 0) setPanes(density);
    path.lightIsIntersectable = chance();
    if (path.light == LightGeometry::DELTA) path.lightIsIntersectable = false;
    path.photons = chance() ? 1000 : 0;
    path.mergeArea = 1e-3 * density();
    path.correlationArea = chance() ? 1e-2 * density() : 0;
    if (chance())
      x[edges].fromLight = path.splats = path.photons = path.connections = 0; // no photons from this light
    countMerges(path);
  }

  /** Sets thin panes before the light, at random distances and angles. Hits and shadow rays have the
   * densities of the straight line, except for the factors of delta lobes. */
  template <class Density> void setPanes(const Density& density) {
    const size_t k = x.size() - 1, j = k - 1 - panes;
    const double pdfDirection = density();
    const bool infinite = path.light == LightGeometry::INFINITE;
    double distance = 0, last = 0, walked = 1, straight = pdfDirection;
    for (size_t i = j + 1; i <= k; ++i) {
      last = density();
      distance += last;
      const double cosine = 1 / (1 + density());
      const bool endless = infinite && i == k;
      x[i].fromCamera = (i == j + 1 ? pdfDirection : 1) * (endless ? 1 : cosine / (last * last));
      x[i].delta = i < k;
      walked *= x[i].fromCamera;
      if (i == k && !infinite) straight *= cosine / (distance * distance);
    }
    if (j == 0 || x[j].delta) return;
    straightWay = walked / straight;
    path.shadowRays = shadowRaysThroughPanes(lightPdf, pdfDirection, infinite ? 1 : distance / last);
  }

  /** Number of samples times density of C_i by (1), including the shadow ray and the hit. */
  double connection(size_t i) const {
    const size_t k = path.edges();
    double p = 1;
    if (panes > 0 && i == k - 1) {
      if (panes == k - 1 || x[k - 1 - panes].delta) return 0;
      for (size_t j = 1; j <= k - 1 - panes; ++j) p *= x[j].fromCamera;
      return p * lightPdf * straightWay;
    }
    for (size_t j = 1; j <= k; ++j) {
      if (i == k - 1 && j == k)
        p *= path.shadowRays;
      else
        p *= j <= i ? x[j].fromCamera : x[j].fromLight;
    }
    if (i == k) return path.lightIsIntersectable ? p : 0;
    if (k == 1 || (i > 0 && x[i].delta) || (i + 1 < k && x[i + 1].delta)) return 0;
    if (i + 1 == k) return p;
    return p * (i == 0 ? path.splats : path.connections);
  }
  /** Number of samples times density of M_i by (2). */
  double merge(size_t i) const {
    double p = x[i].fromLight * x[i].merges;
    for (size_t j = 1; j <= path.edges(); ++j) p *= j <= i ? x[j].fromCamera : x[j].fromLight;
    return p;
  }
};

} // namespace

TEST(BidirectionalWeights, AreDensitiesOverTheirSumAndAddUpToOne) {
  std::mt19937 random(1);
  int merged = 0, paths = 0, throughPanes = 0;
  for (int n = 0; n < 20000; ++n) {
    const size_t k = 1 + size_t(n) % 7;
    const RandomPath r(random, k);
    double all = 0;
    for (size_t i = 0; i <= k; ++i) all += r.connection(i);
    for (size_t i = 1; i + 1 < k; ++i) all += r.merge(i);
    if (!(all > 0)) continue;
    ++paths;
    double sum = 0;
    for (size_t i = 0; i <= k; ++i) {
      if (!(r.connection(i) > 0)) continue;
      const double w = i == k ? hitWeight(r.path) : connectionWeight(r.path, i);
      EXPECT_NEAR(w, r.connection(i) / all, 1e-9) << "C" << i << " of " << k;
      sum += w;
      throughPanes += r.panes > 0 && i + 1 == k && w < 1;
    }
    for (size_t i = 1; i + 1 < k; ++i) {
      if (!(r.merge(i) > 0)) continue;
      const double w = mergeWeight(r.path, i);
      EXPECT_NEAR(w, r.merge(i) / all, 1e-9) << "M" << i << " of " << k;
      sum += w;
      ++merged;
    }
    EXPECT_NEAR(sum, 1, 1e-9);
  }
  EXPECT_GT(paths, 10000);
  EXPECT_GT(merged, 1000);
  EXPECT_GT(throughPanes, 100);
}

TEST(BidirectionalWeights, MergesCountBetweenOneAndAllPhotons) {
  std::mt19937 random(2);
  for (int n = 0; n < 5000; ++n) {
    RandomPath r(random, 3 + size_t(n) % 4);
    r.path.photons = 1000;
    r.path.correlationArea = 0.1;
    countMerges(r.path);
    for (size_t i = 1; i + 1 < r.x.size() - 1; ++i) {
      if (r.x[i].delta) {
        EXPECT_EQ(r.x[i].merges, 0);
        continue;
      }
      const double count = r.x[i].merges / r.path.mergeArea;
      EXPECT_GE(count, 1 - 1e-9);
      EXPECT_LE(count, 1000 + 1e-9);
      if (i == 1) {
        EXPECT_NEAR(count, 1000, 1e-9);
      }
    }
  }
}

/** A mirror keeps visible points in a small area; a matt surface spreads them. */
TEST(BidirectionalWeights, OnlyPhotonsSeenFromManyPlacesAreDependent) {
  for (const bool mirror : {false, true}) {
    std::vector<WeightedVertex> x(5);
    x[1].fromCamera = 1e6;
    x[1].delta = mirror;
    x[2].fromCamera = mirror ? 1 : 1e-3;
    x[3].fromLight = 1e3;
    x[2].fromLight = 1e5;
    WeightedPath path;
    path.vertices = x;
    path.photons = 1e4;
    path.mergeArea = 1;
    path.correlationArea = 1e-2;
    countMerges(path);
    // Matt: Q is 1e-5 and S is 1e-2 · 1e-2 · 1e3 = 1e-1, at most one photon in 1e4.
    if (mirror)
      EXPECT_NEAR(x[2].merges, 1e4, 1e-3);
    else
      EXPECT_NEAR(x[2].merges, 1, 1e-3);
  }
}
