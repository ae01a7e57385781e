/** @file
 * End of a render, and times of its error estimates. All times are seconds since its start, passed in.
 */
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

#include "recurse/render/renderSettings.h"

namespace recurse {

/** Start time of a render, moved back by the time before the interruption that it continues. */
inline std::chrono::steady_clock::time_point startOf(const RenderSettings& settings) {
  using Clock = std::chrono::steady_clock;
  const std::chrono::duration<double> before(settings.from.statistics.renderSeconds);
  return Clock::now() - std::chrono::duration_cast<Clock::duration>(before);
}

/**
 * Time limit, error target and interrupt of a render. Every pixel should get a sample: the limit holds from
 * the second sample on, unless RenderSettings::limitsFirstPass is set, or the first sample takes more than
 * RenderSettings::firstSampleTime beyond it.
 */
class StopRule {
 public:
  /** `hasSamples`: true for a resumed render with samples in its film. */
  StopRule(const RenderSettings& settings, bool hasSamples)
      : limit(settings.timeLimit > 0 ? settings.timeLimit : INFINITY), extraTime(settings.firstSampleTime),
        errorTarget(settings.errorTarget),
        deadline(settings.limitsFirstPass || (hasSamples && settings.from.statistics.renderSeconds > limit)
                     ? limit
                     : INFINITY) {}

  /** Notes that the photons of the first sample exist. Has no effect when called again. */
  void beginFirstSample(double now) {
    if (phase != Phase::PHOTONS) return;
    phase = Phase::FIRST_SAMPLE;
    deadline = std::max(limit, now) + extraTime;
  }
  /** Notes that every pixel has a sample. */
  void completeFirstSample() {
    phase = Phase::MORE_SAMPLES;
    deadline = limit;
  }

  /** True after the deadline of the current phase. Callable from any thread. */
  bool isTimeUp(double now) const { return now > deadline; }
  /** Seconds until the time limit in any phase; infinite without one. */
  double timeLeft(double now) const { return limit - now; }
  /** `error`: Film::relativeError; negative: unknown. */
  bool isErrorReached(double error) const { return errorTarget > 0 && error >= 0 && error <= errorTarget; }
  /** Reason why the render has ended. */
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

/** Timer of an action that recurs. */
class Recurrence {
 public:
  /** First due `interval` seconds after `now`; infinite: never. */
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

/** Error of a film, estimated at intervals that keep its cost low. */
class ErrorWatch {
 public:
  /** Estimates are at least `shortest` seconds apart, and `costRatio` times the duration of an estimate. */
  ErrorWatch(double shortest, double costRatio, double now)
      : shortest(shortest), costRatio(costRatio), next(shortest, now) {}
  bool isDue(double now) const { return next.isDue(now); }
  /** Adds an estimate for a film with `samples`, made from `begin` to `end`. One that is not finite, from too
   * few samples, only restarts the interval. */
  void add(double estimate, double samples, double begin, double end) {
    next.restart(end, std::max(shortest, costRatio * (end - begin)));
    if (!std::isfinite(estimate)) return;
    latest = estimate;
    latestSamples = samples;
  }
  /** Latest estimate; negative: none yet. */
  double error() const { return latest; }
  double samples() const { return latestSamples; }

 private:
  const double shortest, costRatio;
  Recurrence next;
  double latest = -1, latestSamples = 0;
};

} // namespace recurse
