/** @file
 * Large arrays: capacity after growth, and after a failure to grow.
 */
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <new>

#include "recurse/core/threads/largeArray.h"
#include "sanitized.h"

using namespace recurse;

namespace {

constexpr size_t EVERYTHING = size_t(1) << 58; ///< number of 8-byte elements beyond the memory of any machine

} // namespace

TEST(LargeArray, KeepsItsContentWhereAsked) {
  LargeArray<uint64_t> a;
  a.reserve(100);
  for (size_t i = 0; i < 100; ++i) a[i] = i;
  a.reserve(1000, true);
  EXPECT_GE(a.capacity(), 1000u);
  EXPECT_EQ(a.bytes(), a.capacity() * sizeof(uint64_t));
  for (size_t i = 0; i < 100; ++i) EXPECT_EQ(a[i], i);
}

TEST(LargeArray, HasTheRoomThatItSaysAfterAFailure) {
  if (recurse::testing::SANITIZED) GTEST_SKIP() << "sanitizers end a program that runs out of memory";
  LargeArray<uint64_t> a;
  a.reserve(100);
  a[99] = 7;
  EXPECT_THROW(a.reserve(EVERYTHING, true), std::bad_alloc);
  ASSERT_NE(a.data(), nullptr);
  EXPECT_GE(a.capacity(), 100u);
  EXPECT_EQ(a[99], 7u);
  EXPECT_THROW(a.reserve(EVERYTHING), std::bad_alloc);
  EXPECT_EQ(a.capacity(), 0u);
  a.reserve(50);
  ASSERT_NE(a.data(), nullptr);
  a[49] = 1;
}

TEST(LargeArray, RefusesNumbersWhoseBytesOverflow) {
  struct Wide {
    uint64_t values[8];
  };
  constexpr size_t MAX = std::numeric_limits<size_t>::max();
  for (const size_t n : {MAX / sizeof(Wide) + 2, MAX / sizeof(Wide), MAX}) {
    LargeArray<Wide> a;
    EXPECT_THROW(a.reserve(n), std::bad_alloc) << n;
    a.reserve(1);
    EXPECT_THROW(a.reserve(n), std::bad_alloc) << n;
  }
}
