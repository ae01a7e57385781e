/** @file
 * Schedule of a render from given times: its end, the length of its rounds, the checks of its error, and its
 * reports of progress.
 */
#include <gtest/gtest.h>
#include <set>

#include "render/progressEstimate.h"
#include "render/roundSchedule.h"
#include "render/stopRule.h"

using namespace recurse;

namespace {

/** Limit of 10 s; the first sample may take 3 s more. */
RenderSettings tenSeconds() {
  RenderSettings settings;
  settings.timeLimit = 10;
  settings.firstSampleTime = 3;
  return settings;
}

/** First time in quarters of a second at which the time limit is reached; -1: not within an hour. */
double endOf(const StopRule& rule) {
  for (int quarter = 0; quarter < 4 * 3600; ++quarter)
    if (rule.isTimeUp(quarter / 4.)) return quarter / 4.;
  return -1;
}

} // namespace

TEST(StopRule, WithoutALimitTimeIsNeverUp) {
  StopRule rule({}, false);
  EXPECT_EQ(endOf(rule), -1);
  rule.beginFirstSample(5);
  EXPECT_EQ(endOf(rule), -1);
  rule.completeFirstSample();
  EXPECT_EQ(endOf(rule), -1);
  EXPECT_EQ(rule.timeLeft(100), INFINITY);
}

TEST(StopRule, TheFirstSampleMayTakeLonger) {
  StopRule rule(tenSeconds(), false);
  EXPECT_EQ(endOf(rule), -1); // photon passes are completed
  rule.beginFirstSample(4);
  EXPECT_EQ(endOf(rule), 13.25);
  EXPECT_EQ(rule.timeLeft(4), 6);
  rule.completeFirstSample();
  EXPECT_EQ(endOf(rule), 10.25);
}

TEST(StopRule, TheFirstSampleHasItsTimeAfterPhotonsThatTookAllOfIt) {
  StopRule rule(tenSeconds(), false);
  rule.beginFirstSample(60);
  EXPECT_EQ(endOf(rule), 63.25);
  rule.beginFirstSample(62); // a second call has no effect
  EXPECT_EQ(endOf(rule), 63.25);
}

TEST(StopRule, PhotonsEndAtTheLimitWhereThatIsAskedFor) {
  RenderSettings settings = tenSeconds();
  settings.limitsFirstPass = true;
  StopRule rule(settings, false);
  EXPECT_EQ(endOf(rule), 10.25);
  rule.beginFirstSample(9);
  EXPECT_EQ(endOf(rule), 13.25);
}

TEST(StopRule, ARenderThatGoesOnAfterItsTimeEndsAtOnce) {
  RenderSettings settings = tenSeconds();
  for (const double before : {9., 11.})
    for (const bool hasSamples : {false, true}) {
      settings.from.statistics.renderSeconds = before;
      EXPECT_EQ(StopRule(settings, hasSamples).isTimeUp(before), before > 10 && hasSamples);
    }
}

TEST(StopRule, AnInterruptComesBeforeTheErrorAndThatBeforeTheTime) {
  RenderSettings settings = tenSeconds();
  settings.errorTarget = 0.1;
  const StopRule rule(settings, false);
  EXPECT_EQ(rule.reason(true, 0.05, true), StopReason::INTERRUPTED);
  EXPECT_EQ(rule.reason(false, 0.05, false), StopReason::ERROR);
  EXPECT_EQ(rule.reason(false, 0.2, true), StopReason::SAMPLES);
  EXPECT_EQ(rule.reason(false, 0.2, false), StopReason::TIME);
  EXPECT_TRUE(rule.isErrorReached(0.1));
  EXPECT_FALSE(rule.isErrorReached(-1));                         // unknown error
  EXPECT_FALSE(StopRule(tenSeconds(), false).isErrorReached(0)); // no target
}

TEST(StopRule, ErrorsAreEstimatedSoSeldomThatTheyCostLittle) {
  ErrorWatch watch(0.5, 20, 100);
  EXPECT_EQ(watch.error(), -1);
  EXPECT_FALSE(watch.isDue(100.4));
  EXPECT_TRUE(watch.isDue(100.6));
  watch.add(0.3, 64, 100.5, 102.5);
  EXPECT_EQ(watch.error(), 0.3);
  EXPECT_EQ(watch.samples(), 64);
  EXPECT_FALSE(watch.isDue(142));
  EXPECT_TRUE(watch.isDue(143));
  watch.add(NAN, 1, 143, 143.001); // an undefined estimate that took little time
  EXPECT_EQ(watch.error(), 0.3);
  EXPECT_FALSE(watch.isDue(143.4));
  EXPECT_TRUE(watch.isDue(143.6));
}

TEST(StopRule, WhatRecursIsDueAfterItsInterval) {
  EXPECT_FALSE(Recurrence(INFINITY, 0).isDue(1e9));
  Recurrence save(60, 10);
  EXPECT_FALSE(save.isDue(70));
  EXPECT_TRUE(save.isDue(71));
  save.restart(71);
  EXPECT_FALSE(save.isDue(130));
  save.restart(71, 2);
  EXPECT_TRUE(save.isDue(74));
}

TEST(RoundSchedule, RoundsGrowWithTheSamplesThatThereAre) {
  const RoundSchedule schedule(100);
  std::vector<int64_t> lengths;
  for (int64_t sample = 100; sample < 400; sample += lengths.back())
    lengths.push_back(schedule.roundLength(sample, INFINITY));
  EXPECT_EQ(lengths, (std::vector<int64_t>{1, 1, 2, 4, 8, 16, 32, 64, 64, 64, 64}));
}

TEST(RoundSchedule, RoundsEndWithinTheTime) {
  RoundSchedule schedule(0);
  schedule.addRound(4, 2); // half a second per sample
  EXPECT_EQ(schedule.roundLength(32, 100), 32);
  EXPECT_EQ(schedule.roundLength(32, 10), 10); // half of the samples that fit
  EXPECT_EQ(schedule.roundLength(32, 0.6), 1);
  EXPECT_EQ(schedule.roundLength(32, 0.4), 0);
  EXPECT_EQ(schedule.roundLength(32, INFINITY), 32);
}

TEST(RoundSchedule, PhotonMapsThatWouldNotBeReadyAreNotBegun) {
  RoundSchedule schedule(0);
  EXPECT_TRUE(schedule.isPassInTime(0.1)); // no pass has been timed
  schedule.addPass(2);
  schedule.addPass(4);
  EXPECT_TRUE(schedule.isPassInTime(3));
  EXPECT_FALSE(schedule.isPassInTime(2.9));
  EXPECT_TRUE(schedule.isPassInTime(INFINITY));
}

TEST(RoundSchedule, TilesComeInAnOrderThatLeavesNone) {
  for (const size_t count : {1, 2, 3, 8, 40, 97, 600}) {
    const ScatteredOrder order(count);
    std::set<size_t> tiles;
    for (size_t i = 0; i < count; ++i) tiles.insert(order[i]);
    EXPECT_EQ(tiles.size(), count);
    EXPECT_LT(*tiles.rbegin(), count);
  }
}

TEST(ProgressEstimate, TheFirstOfAllLimitsCounts) {
  RenderSettings settings;
  PictureState state;
  state.elapsed = 30;
  state.working = 20;
  state.samplesBefore = 60; // from an earlier process, which took a different time for them
  state.samplesDone = 40;
  EXPECT_EQ(secondsLeft(state, settings), INFINITY);
  state.samplesLeft = 400;
  EXPECT_DOUBLE_EQ(secondsLeft(state, settings), 200);
  settings.errorTarget = 0.1;
  EXPECT_DOUBLE_EQ(secondsLeft(state, settings), 200); // unknown error
  state.error = 0.2; // the target needs four times as many samples as were taken at that error
  state.errorSamples = 80;
  EXPECT_DOUBLE_EQ(secondsLeft(state, settings), 110);
  settings.timeLimit = 100;
  EXPECT_DOUBLE_EQ(secondsLeft(state, settings), 70);
  settings.timeLimit = 10; // in the past
  EXPECT_DOUBLE_EQ(secondsLeft(state, settings), 0);
}

TEST(ProgressEstimate, FractionsAreOfWorkingTime) {
  PictureState state;
  state.elapsed = 30;
  state.working = 20;
  state.samplesDone = 40;
  state.samplesLeft = 120;
  state.rays = 5000;
  state.error = 0.25;
  const RenderProgress p = pictureProgress(state, {});
  EXPECT_EQ(p.phase, "picture");
  EXPECT_EQ(p.elapsed, 30);
  EXPECT_DOUBLE_EQ(p.secondsLeft, 60);
  EXPECT_DOUBLE_EQ(p.fraction, 0.25);
  EXPECT_DOUBLE_EQ(p.raysPerSecond, 250);
  EXPECT_EQ(p.error, 0.25);
  state.samplesLeft = INFINITY;
  EXPECT_EQ(pictureProgress(state, {}).fraction, 0);
  state.samplesLeft = 0;
  EXPECT_EQ(pictureProgress(state, {}).fraction, 1);
}

TEST(ProgressEstimate, TimeForPhotonsIsToldOnceItIsMoreThanNoise) {
  EXPECT_LT(photonProgress(0.01, 3).secondsLeft, 0);
  const RenderProgress p = photonProgress(0.25, 3);
  EXPECT_EQ(p.phase, "photons");
  EXPECT_DOUBLE_EQ(p.secondsLeft, 9);
  EXPECT_EQ(p.fraction, 0.25);
}

TEST(ProgressEstimate, TheEndIsAlwaysTold) {
  std::vector<double> fractions;
  const std::function<void(const RenderProgress&)> show = [&](const RenderProgress& p) {
    fractions.push_back(p.fraction);
  };
  ProgressReporter reporter(show);
  reporter.tell([] { return photonProgress(0.5, 1); });
  reporter.finish(photonProgress(0.5, 1));
  EXPECT_EQ(fractions, (std::vector<double>{0.5, 1}));
  const std::function<void(const RenderProgress&)> none;
  ProgressReporter(none).tell([] { return photonProgress(0.5, 1); });
}
