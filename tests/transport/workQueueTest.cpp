/** @file
 * Work units are completed exactly once, in whatever order they are assigned, interrupted and returned.
 */
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "recurse/render/workQueue.h"

using namespace recurse;

TEST(WorkQueue, EverySampleOnceAndTheSplatsOfEveryPassOnce) {
  std::mt19937 random(5);
  for (const Passes& passes : {Passes::oneMap(), Passes::perSample(), Passes::fixed(3), Passes::fixed(40)})
    for (const int workers : {1, 2, 7, 64}) {
      const int64_t samples = 40, tiles = 13;
      WorkQueue queue(samples, tiles, passes);
      std::map<std::pair<int64_t, int64_t>, int> done;
      std::map<int64_t, int> splats;
      while (const auto unit = queue.take(double(random() % 100), workers)) {
        ASSERT_GT(unit->size(), 0);
        WorkUnit begun = *unit;
        if (random() % 4 == 0) { // interrupted after some samples of some tiles
          WorkUnit rest = begun;
          rest.firstTile += int64_t(random()) % (rest.endTile - rest.firstTile);
          begun.endTile = rest.firstTile;
          rest.includesSplats = begun.size() == 0 && begun.includesSplats;
          queue.giveBack(rest);
        }
        for (int64_t s = begun.firstSample; s < begun.endSample; ++s)
          for (int64_t t = begun.firstTile; t < begun.endTile; ++t) {
            ++done[{s, t}];
            if (begun.includesSplats && t == begun.firstTile) ++splats[s];
          }
      }
      EXPECT_EQ(done.size(), size_t(samples * tiles))
          << passes.minSamples() << " passes, " << workers << " workers";
      for (const auto& [what, times] : done) ASSERT_EQ(times, 1);
      EXPECT_EQ(splats.size(), size_t(samples));
      for (const auto& [sample, times] : splats) ASSERT_EQ(times, 1) << sample;
    }
}

TEST(WorkQueue, UnitsBecomeSmallTowardsTheEnd) {
  WorkQueue queue(1000, 10, Passes::oneMap());
  double last = 0;
  while (const auto unit = queue.take(1000, 4)) {
    EXPECT_LE(unit->size(), 1000);
    last = unit->size();
  }
  EXPECT_EQ(last, 1);
}

TEST(WorkQueue, PassesStayWholeWhileThereAreEnoughForAll) {
  WorkQueue queue(64, 10, Passes::fixed(16)); // four samples per pass
  for (int i = 0; i < 12; ++i) {
    const auto unit = queue.take(30, 4);
    EXPECT_EQ(unit->size(), 40);
    EXPECT_EQ(unit->firstSample, 4 * i);
  }
  // Passes are whole while four are left for the four renderers; the last ones are divided.
  WorkQueue last(4, 10, Passes::fixed(2), {WorkUnit{2, 4, 0, 10}});
  EXPECT_EQ(last.take(1e9, 5)->endTile, 2);
}

TEST(WorkQueue, SamplesOfATileStayTogetherWhereTheyMust) {
  for (const Passes& passes : {Passes::oneMap(), Passes::fixed(4)}) {
    WorkQueue queue(256, 10, passes, {WorkUnit{64, 128, 0, 10}});
    queue.keepPassesWhole();
    double size = 0;
    while (const auto unit = queue.take(100, 4)) {
      EXPECT_EQ(unit->firstSample, 64);
      EXPECT_EQ(unit->endSample, 128);
      EXPECT_LT(unit->endTile - unit->firstTile, 10);
      size += unit->size();
    }
    EXPECT_EQ(size, 640);
  }
}
