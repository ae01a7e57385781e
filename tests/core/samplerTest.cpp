/** @file
 * The sampler: every elementary interval contains one point, and streams are independent.
 */
#include <gtest/gtest.h>
#include <set>

#include "recurse/core/sampling/sampler.h"

using namespace recurse;

TEST(Sampler, EveryPairOfDimensionsIsA02Sequence) {
  // Each elementary interval of area 2^-m contains exactly one of the first 2^m points (Sobol' 1967).
  for (uint64_t stream : {1, 2, 77}) {
    for (int m : {4, 8}) {
      for (int skip : {0, 1, 5}) {
        const int n = 1 << m;
        std::vector<Vec2f> points;
        for (int i = 0; i < n; ++i) {
          Sampler s(9, stream, static_cast<uint32_t>(i));
          for (int k = 0; k < skip; ++k) s.next2D();
          points.push_back(s.next2D());
        }
        for (int a = 0; a <= m; ++a) {
          std::set<std::pair<int, int>> cells;
          for (const Vec2f& p : points)
            cells.insert(
                {static_cast<int>(p.x * float(1 << a)), static_cast<int>(p.y * float(1 << (m - a)))});
          EXPECT_EQ(cells.size(), size_t(n)) << "stream " << stream << " split " << a;
        }
      }
    }
  }
}

TEST(Sampler, OneDimensionIsStratified) {
  std::set<int> cells;
  for (uint32_t i = 0; i < 256; ++i) {
    Sampler s(3, 4, i);
    s.next2D();
    cells.insert(static_cast<int>(s.next1D() * 256));
  }
  EXPECT_EQ(cells.size(), 256u);
}

TEST(Sampler, DimensionsAndStreamsAreUncorrelated) {
  const int n = 4096;
  double acrossDimensions = 0, acrossStreams = 0;
  for (int i = 0; i < n; ++i) {
    Sampler a(1, 10, uint32_t(i)), b(1, 11, uint32_t(i));
    const float x = a.next2D().x - 0.5f;
    acrossDimensions += x * (a.next2D().x - 0.5f);
    acrossStreams += x * (b.next2D().x - 0.5f);
  }
  // The variance of a product of two independent uniforms is 1/144.
  const double sigma = std::sqrt(n / 144.0);
  EXPECT_LT(std::abs(acrossDimensions), 5 * sigma);
  EXPECT_LT(std::abs(acrossStreams), 5 * sigma);
}
