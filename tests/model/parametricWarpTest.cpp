/** @file
 * Warps of tabulated densities against the integrals of the densities.
 */
#include <gtest/gtest.h>

#include <random>

#include "bsdfs/measured/parametricWarp.h"

using namespace recurse;

namespace {

constexpr size_t COLUMNS = 5, ROWS = 4;

/** Two nodes for each parameter; the last slice has an empty cell, and an empty row of cells. */
std::vector<float> tables() {
  std::mt19937 engine(3);
  std::vector<float> values;
  for (size_t i = 0; i < 4 * COLUMNS * ROWS; ++i) values.push_back(static_cast<float>(engine() % 100));
  const size_t last = 3 * COLUMNS * ROWS;
  for (size_t i = 0; i < 2 * COLUMNS; ++i) values[last + i] = 0;
  values[last + 3 * COLUMNS] = values[last + 3 * COLUMNS + 1] = 0;
  values[last + 2 * COLUMNS] = values[last + 2 * COLUMNS + 1] = 0;
  return values;
}

double uniform(std::mt19937& engine) { return (double(engine()) + 0.5) * 0x1p-32; }

const ParameterGrid GRID({0, 1}, {2, 5});

} // namespace

TEST(ParametricWarp, BlendsSlicesBetweenNodes) {
  const SliceTable<float> table(1, 1, {1, 10, 100, 1000});
  EXPECT_EQ(GRID.slices(), 4u);
  EXPECT_FLOAT_EQ(table.at(GRID.at(0, 2), {}), 1);
  EXPECT_FLOAT_EQ(table.at(GRID.at(0, 5), {}), 10);
  EXPECT_FLOAT_EQ(table.at(GRID.at(1, 2), {}), 100);
  EXPECT_FLOAT_EQ(table.at(GRID.at(.25f, 3), {}),
                  .75f * (2 / 3.f * 1 + 1 / 3.f * 10) + .25f * (2 / 3.f * 100 + 1 / 3.f * 1000));
  EXPECT_FLOAT_EQ(table.at(GRID.at(-9, 9), {}), 10) << "beyond the nodes the outer ones go on";
}

TEST(ParametricWarp, InvertUndoesSample) {
  const ParametricWarp warp(COLUMNS, ROWS, tables());
  std::mt19937 engine(5);
  for (const auto& [a, b] : {std::pair(0.f, 2.f), {1.f, 5.f}, {.3f, 4.f}}) {
    const SliceBlend blend = GRID.at(a, b);
    for (int i = 0; i < 5000; ++i) {
      const Vec2d u(uniform(engine), uniform(engine));
      const auto there = warp.sample(blend, u), back = warp.invert(blend, there.at);
      ASSERT_GT(there.pdf, 0);
      ASSERT_NEAR(there.pdf, back.pdf, 1e-5 * (1 + there.pdf));
      ASSERT_NEAR(there.pdf, warp.pdf(blend, there.at), 1e-5 * (1 + there.pdf));
      ASSERT_NEAR(back.at.x, u.x, 2e-5) << i;
      ASSERT_NEAR(back.at.y, u.y, 2e-5) << i;
    }
  }
}

TEST(ParametricWarp, ChanceOfEveryPartIsTheIntegralOfTheBlendedDensities) {
  const std::vector<float> values = tables();
  const ParametricWarp warp(COLUMNS, ROWS, values);
  const SliceBlend blend = GRID.at(.3f, 4);
  const SliceTable<float> table(COLUMNS, ROWS, values);
  // Density by definition: each slice is normalised by its own integral.
  constexpr int PARTS = 6, N = 60;
  std::array<double, 4> whole{};
  const auto integral = [&](uint32_t slice, const Vec2d& low, double width) {
    double sum = 0;
    for (int i = 0; i < N * N; ++i)
      sum += double(table.at({{slice}, {1}, 1}, low + Vec2d(i % N + .5, i / N + .5) * (width / N))); // NOLINT
    return sum * width * width / (N * N);
  };
  for (uint32_t s = 0; s < 4; ++s) whole[s] = integral(s, Vec2d(0), 1);
  std::mt19937 engine(9);
  std::array<int, PARTS * PARTS> found{};
  constexpr int SAMPLES = 200000;
  for (int i = 0; i < SAMPLES; ++i) {
    const Vec2d p = warp.sample(blend, {uniform(engine), uniform(engine)}).at;
    ++found[size_t(std::min(int(p.x * PARTS), PARTS - 1) + PARTS * std::min(int(p.y * PARTS), PARTS - 1))];
  }
  for (int part = 0; part < PARTS * PARTS; ++part) {
    double expected = 0;
    for (uint32_t s = 0; s < blend.count; ++s)
      expected +=
          double(blend.weights[s]) / whole[blend.slices[s]] *
          integral(blend.slices[s], Vec2d(part % PARTS, part / PARTS) / double(PARTS), 1.0 / PARTS); // NOLINT
    EXPECT_NEAR(double(found[size_t(part)]) / SAMPLES, expected, 4 * std::sqrt(expected / SAMPLES) + 2e-4)
        << part;
  }
}

TEST(ParametricWarp, NothingIsEven) {
  const ParametricWarp warp(2, 2, {0, 0, 0, 0});
  const SliceBlend one{{0}, {1}, 1};
  const auto there = warp.sample(one, {.2, .7});
  EXPECT_NEAR(there.at.x, .2, 1e-6);
  EXPECT_NEAR(there.at.y, .7, 1e-6);
  EXPECT_NEAR(there.pdf, 1, 1e-6);
}
