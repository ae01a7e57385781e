/** @file
 * Render loop of a single process.
 */
#include "recurse/render/render.h"

#include <algorithm>
#include <chrono>

#include "recurse/core/io/text.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/core/threads/processorTime.h"
#include "recurse/core/threads/watchdog.h"
#include "render/progressEstimate.h"
#include "render/roundSchedule.h"
#include "render/sampleRenderer.h"
#include "render/stopRule.h"

namespace recurse {

namespace {

using Clock = std::chrono::steady_clock;

/** Shortest time between estimates of the error [s]. An estimate stops all rendering: at most 1 /
 * ERROR_COST_RATIO of the time is spent on it. */
constexpr double ERROR_INTERVAL = 0.2, ERROR_COST_RATIO = 50;

/** Adds the statistics from before the interruption that the render continues. */
void continueFrom(RenderStatistics& now, const RenderStatistics& before) {
  RenderStatistics sum = before;
  sum.threads = now.threads;
  sum.notes = now.notes;
  sum.guide = now.guide;
  sum.warnings = now.warnings;
  sum.learningProcessorSeconds += now.learningProcessorSeconds;
  sum.counts.add(now.counts);
  now = sum;
}

/** Rounds of samples over the whole picture, and the photon maps that they need. */
class RenderLoop final : private RenderPause {
 public:
  RenderLoop(const Scene& scene, Integrator& integrator, const PathClasses& classes,
             const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
             const std::function<void(const RenderProgress&)>& progress,
             const std::function<void(const std::string&)>& log)
      : settings(settings), method(integrator), classes(classes), film(film), stop(stop), log(log),
        start(startOf(settings)),
        processorStart(processorSeconds() - settings.from.statistics.processorSeconds), reporter(progress),
        rule(settings, film.totalSamples() > 0),
        // Learning is skipped when the time is up before the first sample.
        renderer(
            interruptibly([&] { return stop || rule.timeLeft(elapsed()) < 0; },
                          [&] { return SampleRenderer(scene, integrator, classes, settings, film, log); })),
        statistics(renderer.statistics), tileCounts(renderer.tiles()), scattered(renderer.tiles()),
        first(settings.firstSample), last(settings.endSample > 0 ? settings.endSample : renderer.samples()),
        sample(std::max(first, settings.from.sample)), schedule(first),
        errors(ERROR_INTERVAL, ERROR_COST_RATIO, elapsed()),
        saves(settings.save ? settings.saveInterval : INFINITY, elapsed()),
        looks(settings.look ? settings.lookAfter : INFINITY, elapsed()), samplesBefore(film.totalSamples()),
        samplesDone(samplesBefore) {
    continueFrom(statistics, settings.from.statistics);
    if (sample < last) pass = renderer.passOf(sample);
    if (sample > first) rule.completeFirstSample();
    control.stop = &abandon;
    control.progress = [this](double fraction) {
      reporter.tell(
          [&] { return withLearning(photonProgress(fraction, elapsed(), errors.error()), statistics); });
    };
  }

  RenderStatistics run() {
    if (samplesBefore > 0) estimateError();
    renderSamples();
    estimateError();
    if (settings.save) save();
    return summary();
  }

 private:
  double elapsed() const { return secondsSince(start); }
  double timeLeft() const { return rule.timeLeft(elapsed()); }

  void renderSamples() {
    const Watchdog watchdog([this] {
      if (stop || rule.isTimeUp(elapsed())) abandon = true;
    });
    while (isGoingOn() && preparePass() && renderRound()) {
      if (saves.isDue(elapsed())) save();
      if (looks.isDue(elapsed())) look();
      if (isAsked()) settings.answer(*this);
      isPausing = false;
    }
  }
  bool isAsked() const { return settings.isAsked && settings.isAsked(); }
  const Integrator& integrator() const override { return method; }
  void record(int x, int y, int64_t count, PathRecorder& recorder) const override {
    const int64_t begin = std::max(renderer.passBegin(pass), sample - count);
    renderer.recordAside(x, y, uint64_t(begin), uint64_t(std::max(sample, begin + 1)), recorder);
  }
  bool isGoingOn() const {
    return sample < last && !stop && !abandon && !rule.isTimeUp(elapsed()) &&
           !rule.isErrorReached(errors.error());
  }

  /** Shoots the photons of the next sample, unless they exist. False if they are not finished in time. */
  bool preparePass() {
    if (isReady && sample < renderer.passEnd(pass)) return true;
    if (!schedule.isPassInTime(timeLeft())) return false;
    if (isReady) ++pass;
    if (!isReady && pass > 0) shootPass(0, false); // later passes refer to it
    if (!abandon) shootPass(pass, !hasSplats());
    if (abandon) return false;
    if (!isReady) pictureStart = elapsed();
    isReady = true;
    control.progress = [](double) {}; // later photons are a part of the picture's progress
    if (sample == first) rule.beginFirstSample(elapsed());
    return true;
  }
  void shootPass(int64_t index, bool splats) {
    const double begin = elapsed();
    renderer.shootPass(index, splats, control);
    if (index > 0) schedule.addPass(elapsed() - begin);
  }
  /** True if the pass's splats exist: in this film or, if it has any, in the render that began the pass. */
  bool hasSplats() const {
    return film.splats() && (film.splats()->nextPass() > uint64_t(pass) ||
                             (film.splats()->paths() > 0 && sample != renderer.passBegin(pass)));
  }

  /** False if no round would end in time. */
  bool renderRound() {
    const int64_t length = schedule.roundLength(sample, timeLeft());
    if (length == 0) return false;
    const double begin = elapsed();
    SampleAllocation* const allocation = settings.allocation;
    const int64_t stageEnd = allocation ? std::min(SampleAllocation::stageEnd(sample), last) : last;
    if (allocation) allocation->begin(sample, stageEnd, settings.seed);
    const int64_t end = std::min({renderer.passEnd(pass), sample + length, stageEnd});
    if (!renderPixels(end)) return true;
    schedule.addRound(end - sample, elapsed() - begin);
    sample = end;
    rule.completeFirstSample();
    ++statistics.passes;
    if (errors.isDue(elapsed()) || (settings.errorTarget > 0 && renderer.hasOneMap())) estimateError();
    return true;
  }
  /** Takes all samples before `end` that the film does not have. False if the round was abandoned. */
  bool renderPixels(int64_t end) {
    const auto missing = [&](size_t pixel) { return missingSamples(pixel, end); };
    if (sample > first || !(settings.timeLimit > 0)) return renderTiles(missing);
    const auto width = size_t(film.bounds().width());
    for (int stage = 0; stage < CoarseToFine::STAGES; ++stage)
      if (!renderTiles([&](size_t pixel) {
            return CoarseToFine::stageOf(int(pixel % width), int(pixel / width)) == stage
                       ? missing(pixel)
                       : SampleRenderer::PixelSamples{};
          }))
        return false;
    return true;
  }
  bool renderTiles(const std::function<SampleRenderer::PixelSamples(size_t pixel)>& samplesOf) {
    std::atomic<size_t> tilesDone{0};
    parallelFor(tileCounts.size(), [&](size_t number) {
      if (stop || abandon || isPausing) return;
      const size_t tile = settings.timeLimit > 0 ? scattered[number] : number;
      TransportCounts counts;
      const auto [taken, abandoned] = renderer.renderTile(tile, samplesOf, counts, &abandon);
      if (!abandoned) ++tilesDone;
      tileCounts[tile].add(counts);
      samplesDone += taken;
      raysDone += counts.rays;
      if (taken == 0) return;
      if (saves.isDue(elapsed()) || looks.isDue(elapsed()) || isAsked()) isPausing = true;
      reporter.tell([&] { return progressNow(); });
    });
    return tilesDone == tileCounts.size();
  }
  /** Sample range of a pixel; empty if the tile was finished before the round was abandoned. */
  SampleRenderer::PixelSamples missingSamples(size_t pixel, int64_t end) const {
    const SampleAllocation* const allocation = settings.allocation;
    const uint64_t due = allocation ? allocation->due(pixel, end) : uint64_t(end - first);
    const uint64_t before = film.samples(pixel), after = std::max(before, due);
    return {uint64_t(first) + before, uint64_t(first) + after, allocation ? allocation->pilotsDone(pixel) : 0,
            allocation ? allocation->pilotsDue(end) : 0};
  }

  PictureState state() const {
    const auto area = double(film.bounds().area()), done = double(samplesDone);
    PictureState s;
    s.elapsed = elapsed();
    s.working = s.elapsed - pictureStart;
    s.samplesBefore = double(samplesBefore);
    s.samplesDone = done - s.samplesBefore;
    if (settings.samplesPerPixel > 0) s.samplesLeft = double(last - first) * area - done;
    s.samplesPerPixel = done / area;
    s.rays = double(raysDone);
    s.error = errors.error();
    s.errorSamples = errors.samples();
    return s;
  }
  RenderProgress progressNow() const { return withLearning(pictureProgress(state(), settings), statistics); }
  void estimateError() {
    const double begin = elapsed(), error = film.relativeError();
    errors.add(error, double(film.totalSamples()), begin, elapsed());
    if (errors.error() >= 0) statistics.error = errors.error();
  }
  void save() {
    RenderPosition position{sample, statistics};
    addTotals(position.statistics);
    position.statistics.notes.clear();
    position.statistics.warnings.clear();
    settings.save(position);
    saves.restart(elapsed());
  }
  void look() {
    const double interval = settings.look();
    looks.restart(elapsed(), interval);
  }

  void addTotals(RenderStatistics& out) const {
    for (const TransportCounts& c : tileCounts) out.counts.add(c);
    out.renderSeconds = elapsed();
    out.processorSeconds = processorSeconds() - processorStart;
  }
  RenderStatistics summary() {
    statistics.oneMap = renderer.hasOneMap() && statistics.photonsEmitted > 0;
    const size_t warningsBefore = statistics.warnings.size();
    countSamples(film, statistics);
    if (log && statistics.warnings.size() > warningsBefore) log("warning: " + statistics.warnings.back());
    addTotals(statistics);
    warnOfDarkFrames(film, classes, statistics, log);
    statistics.gatherSeconds =
        statistics.renderSeconds - statistics.photonSeconds - statistics.balanceSeconds;
    statistics.stopReason = rule.reason(stop, errors.error(), sample >= last);
    reporter.finish(progressNow());
    return statistics;
  }

  const RenderSettings& settings;
  const Integrator& method;
  const PathClasses& classes;
  Film& film;
  const std::atomic<bool>& stop;
  const std::function<void(const std::string&)>& log;
  const Clock::time_point start; ///< earlier by the time before an interruption
  const double processorStart;
  ProgressReporter reporter;
  StopRule rule;
  SampleRenderer renderer;
  RenderStatistics& statistics;
  std::vector<TransportCounts> tileCounts;
  const ScatteredOrder scattered;
  const int64_t first, last;
  int64_t sample;   ///< every pixel has all samples before it
  int64_t pass = 0; ///< pass of `sample`; the previous one until its photons exist
  bool isReady = false;
  RoundSchedule schedule;
  ErrorWatch errors;
  Recurrence saves, looks;
  double pictureStart = 0; ///< seconds since `start`
  const uint64_t samplesBefore;
  std::atomic<uint64_t> samplesDone, raysDone{0};
  std::atomic<bool> abandon{false};   ///< stops everything: the time is up, or by request
  std::atomic<bool> isPausing{false}; ///< ends the round, for save() or look()
  ForwardControl control;
};

} // namespace

void warnOfDarkFrames(const Film& film, const PathClasses& classes, RenderStatistics& statistics,
                      const std::function<void(const std::string&)>& log) {
  if (!classes.isTransient() || film.totalSamples() == 0) return;
  for (size_t layer = 0; layer < classes.layerCount(); ++layer) {
    if (!TransientFrames::isFrameName(classes.classes()[layer].name)) continue;
    for (size_t p = 0; p < film.bounds().area(); ++p)
      if (!isBlack(film.value(p, layer))) return;
  }
  const LengthRange& lengths = statistics.counts.lengths;
  const std::string frames =
      formatted("no light arrives within the frames, at path lengths from %.4g to %.4g",
                classes.frames().from(), classes.frames().to());
  statistics.warnings.push_back(lengths.empty()
                                    ? frames + ": the picture is black"
                                    : frames + formatted(": all light arrives between lengths %.4g and %.4g",
                                                         double(lengths.least), double(lengths.most)));
  if (log) log("warning: " + statistics.warnings.back());
}

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
    statistics.warnings.push_back(formatted(
        "%td of %zu pixels have no sample; they copy a neighbour or are black: give the render more time",
        without, counts.size()));
  }
}

RenderStatistics render(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                        const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                        const std::function<void(const RenderProgress&)>& progress,
                        const std::function<void(const std::string&)>& log) {
  if (settings.from.left)
    throw Error("--resume: several processes made this checkpoint; only recurse-mpi can continue it");
  return RenderLoop(scene, integrator, classes, settings, film, stop, progress, log).run();
}

RenderStatistics runFirstForwardPass(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                                     const RenderSettings& settings) {
  Film film(scene.film().crop, classes.layerCount());
  SampleRenderer renderer(scene, integrator, classes, settings, film, {});
  ForwardControl control;
  renderer.shootPass(0, false, control);
  return renderer.statistics;
}

} // namespace recurse
