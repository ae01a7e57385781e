/** @file
 * The render loop.
 */
#include "recurse/render/render.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <numeric>

#include "recurse/core/io/text.h"
#include "recurse/core/threads/interrupt.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/core/threads/processorTime.h"
#include "render/sampleRenderer.h"
#include "render/watchdog.h"

namespace recurse {

namespace {

using Clock = std::chrono::steady_clock;

/** Samples of one round at the most: a round is the unit in which all pixels are equal. */
constexpr int LARGEST_ROUND = 64;
double seconds(Clock::duration d) { return std::chrono::duration<double>(d).count(); }

/** Tells the progress display at most ten times a second, from one thread at a time. */
class ProgressReporter {
 public:
  ProgressReporter(const std::function<void(const RenderProgress&)>& tell, Clock::time_point start)
      : tell(tell), start(start) {}
  std::atomic<double> error{-1}; ///< as RenderProgress has it

  void say(const char* phase, double fraction, double secondsLeft, double samples, double rays,
           bool always = false) {
    if (!tell || !one.try_lock()) return;
    const std::lock_guard<std::mutex> guard(one, std::adopt_lock);
    const Clock::time_point now = Clock::now();
    if (!always && seconds(now - last) < 0.1) return;
    last = now;
    RenderProgress p;
    p.phase = phase;
    p.fraction = fraction;
    p.elapsed = seconds(now - start);
    p.secondsLeft = secondsLeft;
    p.samplesPerPixel = samples;
    p.raysPerSecond = rays;
    p.error = error;
    tell(p);
  }

 private:
  const std::function<void(const RenderProgress&)>& tell;
  Clock::time_point start, last{};
  std::mutex one;
};

/** An order of tiles without rows or columns, so that a round which is broken off leaves no band. */
class ScatteredOrder {
 public:
  explicit ScatteredOrder(size_t count) : count(count), step(std::max<size_t>(1, count * 5 / 8)) {
    while (std::gcd(step, count) != 1) ++step;
  }
  size_t operator[](size_t i) const { return i * step % count; }

 private:
  size_t count, step;
};

/** Adds what was found out before a render was interrupted. */
void continueFrom(RenderStatistics& now, const RenderStatistics& before) {
  RenderStatistics sum = before;
  sum.threads = now.threads;
  sum.notes = now.notes;
  sum.warnings = now.warnings;
  sum.learningProcessorSeconds += now.learningProcessorSeconds;
  now = sum;
}

} // namespace

void countSamples(const Film& film, RenderStatistics& statistics) {
  if (film.splats()) statistics.splatsSaturated = film.splats()->saturated();
  statistics.samples = film.totalSamples();
  std::vector<uint64_t> counts(film.bounds().area());
  for (size_t i = 0; i < counts.size(); ++i) counts[i] = film.samples(i);
  const auto middle = counts.begin() + std::ptrdiff_t((counts.size() - 1) / 2);
  std::nth_element(counts.begin(), middle, counts.end());
  statistics.median = *middle;
  const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
  statistics.least = *least;
  statistics.most = *most;
  if (const auto without = std::count(counts.begin(), counts.end(), 0u);
      without > 0 && statistics.samples > 0) {
    statistics.warnings.push_back(
        formatted("%td of %zu pixels have no sample, and are black", without, counts.size()));
  }
}

RenderStatistics render(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                        const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                        const std::function<void(const RenderProgress&)>& progress,
                        const std::function<void(const std::string&)>& log) {
  if (settings.from.left)
    throw Error("--resume: several processes shared this render; recurse-mpi goes on with it");
  // A render that goes on takes its time with it.
  const Clock::time_point now = Clock::now();
  const Clock::time_point start =
      now - std::chrono::duration_cast<Clock::duration>(
                std::chrono::duration<double>(settings.from.statistics.renderSeconds));
  const double processorStart = processorSeconds() - settings.from.statistics.processorSeconds;
  ProgressReporter reporter(progress, start);
  // Of what is learned before the first sample none is needed.
  SampleRenderer renderer = [&] {
    std::atomic<bool> enough{false};
    const Watchdog watchdog([&] {
      if (stop || (settings.timeLimit > 0 && seconds(Clock::now() - start) > settings.timeLimit))
        enough = true;
    });
    const InterruptibleWork learning(&enough);
    return SampleRenderer(scene, integrator, classes, settings, film, log);
  }();
  RenderStatistics& statistics = renderer.statistics;
  continueFrom(statistics, settings.from.statistics);

  std::atomic<bool> abandon{false}; ///< what is under way: the time is up, or somebody said so
  ForwardControl control;
  control.stop = &abandon;
  control.progress = [&](double fraction) {
    const double elapsed = seconds(Clock::now() - start);
    reporter.say("photons", fraction, fraction > 0.02 ? elapsed / fraction - elapsed : -1, 0, 0);
  };
  double forwardSeconds = 0; ///< of the `shots` that were made here, but for the first pass, which learns
  int shots = 0;
  const auto shootPass = [&](int64_t index, bool splats) {
    const Clock::time_point passStart = Clock::now();
    renderer.shootPass(index, splats, control);
    if (index == 0) return;
    forwardSeconds += seconds(Clock::now() - passStart);
    ++shots;
  };

  const PixelBounds& bounds = film.bounds();
  const size_t tiles = renderer.tiles();
  const int64_t wanted = renderer.samples();
  Clock::time_point pictureStart = start;
  std::vector<TransportCounts> tileCounts(tiles);
  const int64_t first = settings.firstSample, last = settings.endSample > 0 ? settings.endSample : wanted;
  SampleAllocation* const allocation = settings.allocation;
  const uint64_t samplesBefore = film.totalSamples();
  std::atomic<uint64_t> samplesDone{samplesBefore}, raysDone{0};
  std::atomic<bool> timeUp{settings.timeLimit > 0 && samplesBefore > 0 &&
                           settings.from.statistics.renderSeconds > settings.timeLimit};

  bool errorReached = false;
  Clock::time_point errorLooked = start;
  double errorSeconds = 0; ///< that looking takes
  double errorTime = 0;    ///< of the picture, when it was looked at
  // Between rounds, and seldom enough to cost next to nothing.
  const auto lookAtError = [&](bool always) {
    const Clock::time_point now = Clock::now();
    if (!always && seconds(now - errorLooked) < std::max(0.2, 50 * errorSeconds)) return;
    const double error = film.relativeError();
    errorLooked = Clock::now();
    errorSeconds = seconds(errorLooked - now);
    if (!std::isfinite(error)) return;
    reporter.error = statistics.error = error;
    errorTime = seconds(errorLooked - pictureStart);
    errorReached = settings.errorTarget > 0 && error <= settings.errorTarget;
  };

  int64_t sample = std::max(first, settings.from.sample), pass = 0;
  if (sample < last) pass = renderer.passOf(sample);
  // Of parts that share a pass one has its splats; but none is without any.
  const auto isSplatted = [&] {
    return film.splats() && (film.splats()->nextPass() > uint64_t(pass) ||
                             (film.splats()->paths() > 0 && sample != renderer.passBegin(pass)));
  };

  Clock::time_point saved = Clock::now();
  std::atomic<bool> saveDue{false};
  const auto save = [&] {
    RenderPosition position{sample, statistics};
    for (const TransportCounts& c : tileCounts) position.statistics.counts.add(c);
    position.statistics.renderSeconds = seconds(Clock::now() - start);
    position.statistics.processorSeconds = processorSeconds() - processorStart;
    position.statistics.notes.clear();
    position.statistics.warnings.clear();
    settings.save(position);
    saved = Clock::now();
    saveDue = false;
  };

  Clock::time_point looked = Clock::now();
  double lookAfter = settings.lookAfter;
  std::atomic<bool> lookDue{false};
  const auto look = [&] {
    lookAfter = settings.look();
    looked = Clock::now();
    lookDue = false;
  };

  // Every pixel is to have a sample: the first round may take longer.
  std::atomic<double> endOfTime{sample == first ? double(INFINITY) : settings.timeLimit};
  const Watchdog watchdog([&] {
    if (settings.timeLimit > 0 && seconds(Clock::now() - start) > endOfTime) timeUp = true;
    if (stop || timeUp) abandon = true;
  });
  double sampleSeconds = 0; ///< that one sample of each pixel took last
  const ScatteredOrder scattered(tiles);

  if (samplesBefore > 0) lookAtError(true);
  bool ready = false; // has the photons of `pass`
  while (sample < last && !stop && !timeUp && !errorReached) {
    if (!ready || sample == renderer.passEnd(pass)) {
      if (ready) ++pass;
      // A pass that would not be ready in time is not begun: too few photons are worth nothing.
      if (shots > 0 && settings.timeLimit > 0 &&
          seconds(Clock::now() - start) + forwardSeconds / shots > settings.timeLimit)
        break;
      if (settings.limitsFirstPass) endOfTime = settings.timeLimit;
      if (!ready && pass > 0) shootPass(0, false); // which the later ones look back at
      if (!abandon) shootPass(pass, !isSplatted());
      if (abandon) break;
      // From the second pass on the photons' progress is a part of the picture's.
      control.progress = [](double) {};
      if (!ready) pictureStart = Clock::now();
      ready = true;
      if (sample == first)
        endOfTime = std::max(settings.timeLimit, seconds(Clock::now() - start)) + settings.firstSampleTime;
    }
    int64_t round = std::clamp<int64_t>(sample - first, 1, LARGEST_ROUND);
    if (settings.timeLimit > 0 && sampleSeconds > 0) {
      // Rounds come to their end within the time, so that all pixels are equal.
      const double left = settings.timeLimit - seconds(Clock::now() - start);
      if (left < sampleSeconds) break;
      round = std::clamp<int64_t>(int64_t(left / sampleSeconds / 2), 1, round);
    }
    const Clock::time_point roundStart = Clock::now();
    const int64_t stageEnd = allocation ? std::min(SampleAllocation::stageEnd(sample), last) : last;
    if (allocation) allocation->begin(sample, stageEnd, settings.seed);
    const int64_t end = std::min({renderer.passEnd(pass), sample + round, stageEnd});
    // How many samples of a pixel there are to be at the end of the round.
    const auto due = [&](size_t pixel) {
      return allocation ? allocation->due(pixel, end) : uint64_t(end - first);
    };
    const auto samplesOf = [&](size_t pixel) {
      // None is left where the tile was done before the round was interrupted.
      const uint64_t before = film.samples(pixel), after = std::max(before, due(pixel));
      return SampleRenderer::PixelSamples{uint64_t(first) + before, uint64_t(first) + after,
                                          allocation ? allocation->pilotsDone(pixel) : 0,
                                          allocation ? allocation->pilotsDue(end) : 0};
    };
    std::atomic<size_t> tilesDone{0};
    parallelFor(tiles, [&](size_t number) {
      if (stop || timeUp || saveDue || lookDue) return;
      const size_t tile = settings.timeLimit > 0 ? scattered[number] : number;
      TransportCounts counts;
      const auto [taken, abandoned] = renderer.renderTile(tile, samplesOf, counts, &abandon);
      if (!abandoned) ++tilesDone;
      tileCounts[tile].add(counts);
      if (taken == 0) return;
      const uint64_t samples = samplesDone += taken;
      const uint64_t rays = raysDone += counts.rays;
      const double elapsed = seconds(Clock::now() - start), inPicture = seconds(Clock::now() - pictureStart);
      if (settings.save && seconds(Clock::now() - saved) > settings.saveInterval) saveDue = true;
      if (settings.look && seconds(Clock::now() - looked) > lookAfter) lookDue = true;
      const double perPixel = double(samples) / double(bounds.area());
      double left = INFINITY;
      if (settings.samplesPerPixel > 0) {
        const double all = double(last - first) * double(bounds.area());
        left = inPicture * (all - double(samples)) / double(samples - samplesBefore);
      }
      if (settings.errorTarget > 0 && reporter.error > 0) // the error falls as one over the root of time
        left = std::min(left, errorTime * square(reporter.error / settings.errorTarget) - inPicture);
      if (settings.timeLimit > 0) left = std::min(left, settings.timeLimit - elapsed);
      left = std::max(left, 0.0);
      reporter.say("picture", inPicture / (inPicture + left), left, perPixel, double(rays) / inPicture);
    });
    const bool isComplete = tilesDone == tiles;
    if (settings.timeLimit > 0 && (isComplete || sample > first) &&
        seconds(Clock::now() - start) > settings.timeLimit)
      timeUp = true;
    if (isComplete) {
      sampleSeconds = seconds(Clock::now() - roundStart) / double(end - sample);
      sample = end;
      endOfTime = settings.timeLimit;
      ++statistics.passes;
      lookAtError(settings.errorTarget > 0 && renderer.hasOneMap());
    }
    if (saveDue) save();
    if (lookDue) look();
  }
  lookAtError(true);
  if (settings.save) save();

  statistics.oneMap = renderer.hasOneMap() && statistics.photonsEmitted > 0;
  for (const TransportCounts& c : tileCounts) statistics.counts.add(c);
  const size_t warningsBefore = statistics.warnings.size();
  countSamples(film, statistics);
  if (log && statistics.warnings.size() > warningsBefore) log("warning: " + statistics.warnings.back());
  statistics.renderSeconds = seconds(Clock::now() - start);
  statistics.processorSeconds = processorSeconds() - processorStart;
  statistics.gatherSeconds = statistics.renderSeconds - statistics.photonSeconds - statistics.balanceSeconds;
  if (stop)
    statistics.stopReason = StopReason::INTERRUPTED;
  else if (errorReached)
    statistics.stopReason = StopReason::ERROR;
  else if (sample < last)
    statistics.stopReason = StopReason::TIME;
  reporter.say("picture", 1, 0, double(statistics.samples) / double(bounds.area()),
               double(raysDone) / std::max(statistics.gatherSeconds, 1e-9), true);
  return statistics;
}

RenderStatistics shootFirstPass(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                                const RenderSettings& settings) {
  Film film(scene.film().crop, classes.layerCount());
  SampleRenderer renderer(scene, integrator, classes, settings, film, {});
  ForwardControl control;
  renderer.shootPass(0, false, control);
  return renderer.statistics;
}

} // namespace recurse
