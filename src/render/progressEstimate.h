/** @file
 * Progress figures for displays, computed from given times.
 */
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <mutex>

#include "recurse/render/renderSettings.h"

namespace recurse {

/** Progress of a render's samples; times in seconds. A resumed render had samples before this process. */
struct PictureState {
  double elapsed = 0;            ///< since the start of the render
  double working = 0;            ///< since the first sample of this process
  double samplesBefore = 0;      ///< in the film when this process began, in any unit
  double samplesDone = 0;        ///< by this process, in the same unit
  double samplesLeft = INFINITY; ///< in the same unit; infinite: no limit
  double samplesPerPixel = 0;    ///< in the film
  double rays = 0;               ///< traced by this process
  double error = -1;             ///< Film::relativeError; negative: unknown
  double errorSamples = 0;       ///< in the film at the time of the estimate
};

/** Seconds until the first of all limits: samples, error and time. Infinite without any limit. */
inline double secondsLeft(const PictureState& state, const RenderSettings& settings) {
  double samples = state.samplesLeft;
  if (settings.errorTarget > 0 && state.error > 0) { // the error falls as samples^-1/2
    const double ratio = state.error / settings.errorTarget;
    samples = std::min(samples, state.errorSamples * ratio * ratio - state.samplesBefore - state.samplesDone);
  }
  const double left = state.samplesDone > 0 ? samples * (state.working / state.samplesDone) : INFINITY;
  const double limit = settings.timeLimit > 0 ? settings.timeLimit - state.elapsed : INFINITY;
  return std::max(0.0, std::min(left, limit));
}

inline RenderProgress pictureProgress(const PictureState& state, const RenderSettings& settings) {
  RenderProgress p;
  p.phase = "picture";
  p.elapsed = state.elapsed;
  p.secondsLeft = secondsLeft(state, settings);
  p.fraction = p.secondsLeft > 0 ? state.working / (state.working + p.secondsLeft) : 1;
  p.samplesPerPixel = state.samplesPerPixel;
  p.raysPerSecond = state.rays / std::max(state.working, 1e-9);
  p.error = state.error;
  return p;
}

/** The progress with what has been learned. */
inline RenderProgress withLearning(RenderProgress p, const RenderStatistics& statistics) {
  p.learningSeconds = statistics.learningProcessorSeconds;
  p.guide = statistics.guide;
  return p;
}

/** Progress of the photons before the first sample: `fraction` of them are made. The remaining time is
 * extrapolated once 2 % are. */
inline RenderProgress photonProgress(double fraction, double elapsed, double error = -1) {
  RenderProgress p;
  p.phase = "photons";
  p.fraction = fraction;
  p.elapsed = elapsed;
  if (fraction > 0.02) p.secondsLeft = elapsed / fraction - elapsed;
  p.error = error;
  return p;
}

/** Reports to a progress display at most ten times a second, from one thread at a time. */
class ProgressReporter {
 public:
  explicit ProgressReporter(const std::function<void(const RenderProgress&)>& show) : show(show) {}

  /** Calls `progress()` if a report is due. */
  template <class Progress> void tell(const Progress& progress) {
    if (!show || !one.try_lock()) return;
    const std::lock_guard<std::mutex> guard(one, std::adopt_lock);
    const Clock::time_point now = Clock::now();
    if (now - last < std::chrono::milliseconds(100)) return;
    last = now;
    show(progress());
  }
  /** Reports the final progress in any case. */
  void finish(RenderProgress progress) const {
    progress.fraction = 1;
    progress.secondsLeft = 0;
    if (show) show(progress);
  }

 private:
  using Clock = std::chrono::steady_clock;
  const std::function<void(const RenderProgress&)>& show;
  Clock::time_point last{};
  std::mutex one;
};

} // namespace recurse
