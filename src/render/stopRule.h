/** @file
 * When a render ends, and when it looks at its error. All times are seconds since its start, and given.
 */
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

#include "recurse/render/renderSettings.h"

namespace recurse {

/** When a render that begins now would have begun without the interruption that it goes on from. */
inline std::chrono::steady_clock::time_point startOf(const RenderSettings& settings) {
  using Clock = std::chrono::steady_clock;
  const std::chrono::duration<double> before(settings.from.statistics.renderSeconds);
  return Clock::now() - std::chrono::duration_cast<Clock::duration>(before);
}

/**
 * The time limit, the error target and the interrupt of a render. Every pixel is to have a sample: the limit
 * counts from the second sample on, unless RenderSettings::limitsFirstPass or the first one takes more than
 * RenderSettings::firstSampleTime beyond it.
 */
class StopRule {
 public:
  /** `hasSamples`: the film of a render that goes on has some. */
  StopRule(const RenderSettings& settings, bool hasSamples)
      : limit(settings.timeLimit > 0 ? settings.timeLimit : INFINITY), extraTime(settings.firstSampleTime),
        errorTarget(settings.errorTarget),
        deadline(settings.limitsFirstPass || (hasSamples && settings.from.statistics.renderSeconds > limit)
                     ? limit
                     : INFINITY) {}

  /** The photons of the first sample are there. Has no effect when called again. */
  void beginFirstSample(double now) {
    if (phase != Phase::PHOTONS) return;
    phase = Phase::FIRST_SAMPLE;
    deadline = std::max(limit, now) + extraTime;
  }
  /** Every pixel has a sample. */
  void completeFirstSample() {
    phase = Phase::MORE_SAMPLES;
    deadline = limit;
  }

  /** Any thread. */
  bool isTimeUp(double now) const { return now > deadline; }
  /** Until the time limit [s], whatever the phase; infinite without one. */
  double timeLeft(double now) const { return limit - now; }
  /** `error`: Film::relativeError; negative: not known. */
  bool isErrorReached(double error) const { return errorTarget > 0 && error >= 0 && error <= errorTarget; }
  /** Why a render has ended. */
  StopReason reason(bool isInterrupted, double error, bool hasAllSamples) const {
    if (isInterrupted) return StopReason::INTERRUPTED;
    if (isErrorReached(error)) return StopReason::ERROR;
    return hasAllSamples ? StopReason::SAMPLES : StopReason::TIME;
  }

 private:
  enum class Phase { PHOTONS, FIRST_SAMPLE, MORE_SAMPLES };
  const double limit, extraTime, errorTarget;
  Phase phase = Phase::PHOTONS;
  std::atomic<double> deadline;
};

/** Something that is done again and again. */
class Recurrence {
 public:
  /** Due `interval` seconds after `now`; infinite: never. */
  Recurrence(double interval, double now) : interval(interval), last(now) {}
  bool isDue(double now) const { return now - last > interval; }
  void restart(double now) { last = now; }
  void restart(double now, double nextInterval) {
    last = now;
    interval = nextInterval;
  }

 private:
  double interval, last;
};

/** The error of a film, estimated at intervals that keep the cost of it low. */
class ErrorWatch {
 public:
  /** At least `shortest` seconds, and `costRatio` times what an estimate takes, from one to the next. */
  ErrorWatch(double shortest, double costRatio, double now)
      : shortest(shortest), costRatio(costRatio), next(shortest, now) {}
  bool isDue(double now) const { return next.isDue(now); }
  /** Takes an estimate of a film with `samples`, made from `begin` to `end`; not finite: these are too few.
   */
  void add(double estimate, double samples, double begin, double end) {
    next.restart(end, std::max(shortest, costRatio * (end - begin)));
    if (!std::isfinite(estimate)) return;
    latest = estimate;
    latestSamples = samples;
  }
  /** The latest one; negative: there is none. */
  double error() const { return latest; }
  double samples() const { return latestSamples; }

 private:
  const double shortest, costRatio;
  Recurrence next;
  double latest = -1, latestSamples = 0;
};

} // namespace recurse
