/** @file
 * Colours: a separate type with arithmetic by component.
 */
#include <type_traits>

#include <gtest/gtest.h>

#include "recurse/core/math/rgb.h"

using namespace recurse;

static_assert(!std::is_convertible_v<Vec3f, Rgb> && !std::is_convertible_v<Rgb, Vec3f>);
static_assert(!std::is_convertible_v<Rgbd, Rgb> && std::is_convertible_v<Rgb, Rgbd>);
static_assert(std::is_trivially_copyable_v<Rgb> && sizeof(Rgb) == 3 * sizeof(float));

TEST(Rgb, CalculatesByComponent) {
  const Rgb a(1, 2, 4), b(0.5f, 4, -8);
  EXPECT_EQ(a + b, Rgb(1.5f, 6, -4));
  EXPECT_EQ(1 - a, Rgb(0, -1, -3));
  EXPECT_EQ(a * b / 2, Rgb(0.25f, 4, -16));
  EXPECT_EQ(2 / a, Rgb(2, 1, 0.5f));
  EXPECT_EQ(min(a, b), Rgb(0.5f, 2, -8));
  EXPECT_EQ(max(a, b), Rgb(1, 4, 4));
  EXPECT_EQ(clamp(b, 0, 1), Rgb(0.5f, 1, 0));
  EXPECT_EQ(sqrt(Rgb(4, 9, 16)), Rgb(2, 3, 4));
  EXPECT_EQ(Mat3f(0, 1, 0, 0, 0, 1, 1, 0, 0) * a, Rgb(4, 1, 2)) << "column major";
  EXPECT_EQ(maxComponent(b), 4);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(a[c], c == 0 ? a.r : c == 1 ? a.g : a.b);
}
