/** @file
 * The render loop.
 */
#include "recurse/transport/render.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <mutex>

#include "recurse/core/inPlace.h"
#include "recurse/core/parallel.h"

namespace recurse {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int TILE = 16;
/** Samples of one round at the most: a round is the unit in which all pixels are equal. */
constexpr int LARGEST_ROUND = 64;

double seconds(Clock::duration d) { return std::chrono::duration<double>(d).count(); }
/** What the threads of the process have worked so far. */
double processorSeconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

/** Tells the progress display at most ten times a second, from one thread at a time. */
class Teller {
 public:
  Teller(const std::function<void(const RenderProgress&)>& tell, Clock::time_point start)
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

/** Collects eye paths, has them walked together, and puts what they bring into the film in the same order. */
class EyeBatch {
 public:
  EyeBatch(const Scene& scene, const Integrator& integrator, const PathClasses& classes,
           TransportCounts& counts, Film& film, SampleAllocation* allocation)
      : scene(scene), integrator(integrator), film(film), allocation(allocation),
        radiance(EYE_BATCH, PathRadiance(classes, counts)) {
    paths.reserve(EYE_BATCH);
  }
  /** Sample `index` of a pixel, whose upper left corner is at `corner` on the film. `pilot`: the allocation
   * is told of it. */
  void add(uint64_t seed, uint64_t stream, uint32_t index, size_t pixel, const Vec2f& corner,
           float sampleSpacing, bool pilot) {
    Place& place = places[paths.size()];
    EyePath& path = paths.emplace_back(Sampler(seed, stream, index), radiance[paths.size()]);
    const Filter::Sample f = scene.filter().sample(path.sampler.next2D());
    makeAt(path.ray, [&] { return scene.camera().ray(corner + 0.5f + f.offset); });
    path.ray.sampleSpacing = sampleSpacing;
    path.out->reset();
    place.pixel = pixel;
    place.weight = f.weight;
    place.pilot = pilot;
    if (paths.size() == EYE_BATCH) flush();
  }
  void flush() {
    if (paths.empty()) return;
    integrator.backwardBatch(scene, paths);
    for (size_t i = 0; i < paths.size(); ++i) {
      film.add(places[i].pixel, places[i].weight, radiance[i].values(), radiance[i].total());
      if (places[i].pilot) allocation->addPilot(places[i].pixel, double(luminance(radiance[i].total())));
    }
    paths.clear();
  }

 private:
  struct Place {
    size_t pixel;
    float weight;
    bool pilot;
  };
  const Scene& scene;
  const Integrator& integrator;
  Film& film;
  SampleAllocation* allocation;
  std::vector<PathRadiance> radiance;
  std::vector<EyePath> paths;
  std::array<Place, EYE_BATCH> places;
};

} // namespace

RenderStatistics render(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                        const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                        const std::function<void(const RenderProgress&)>& progress,
                        const std::function<void(const std::string&)>& log) {
  // A render that goes on takes its time with it.
  const Clock::time_point now = Clock::now();
  const Clock::time_point start =
      now - std::chrono::duration_cast<Clock::duration>(
                std::chrono::duration<double>(settings.from.statistics.renderSeconds));
  const double processorStart = processorSeconds() - settings.from.statistics.processorSeconds;
  Teller teller(progress, start);
  RenderStatistics statistics = settings.from.statistics;
  statistics.threads = threadCount();
  integrator.prepare(scene, classes);

  ForwardControl control;
  control.stop = &stop;
  control.progress = [&](double fraction) {
    const double elapsed = seconds(Clock::now() - start);
    teller.say("photons", fraction, fraction > 0.02 ? elapsed / fraction - elapsed : -1, 0, 0);
  };
  const int passes = integrator.passes(settings.samplesPerPixel);
  double forwardSeconds = 0; ///< of the `shots` that were made here
  int shots = 0;
  const auto shootPass = [&](uint32_t index) {
    const Clock::time_point passStart = Clock::now();
    const ForwardStatistics forward =
        integrator.forward(scene, classes, {settings.seed, index, passes == 1}, control);
    forwardSeconds += seconds(Clock::now() - passStart);
    ++shots;
    statistics.photonSeconds += forward.shootSeconds;
    statistics.balanceSeconds += forward.balanceSeconds;
    statistics.mapBytes = std::max(statistics.mapBytes, forward.mapBytes);
    statistics.photonsEmitted += forward.photonsEmitted;
    statistics.photonsStored += forward.photonsStored;
    statistics.photonsRefused += forward.photonsRefused;
    statistics.counts.add(forward.counts);
    ++statistics.forwardPasses;
    statistics.notes.insert(statistics.notes.end(), forward.notes.begin(), forward.notes.end());
    statistics.warnings.insert(statistics.warnings.end(), forward.warnings.begin(), forward.warnings.end());
    if (log) {
      for (const std::string& note : forward.notes) log(note);
      for (const std::string& warning : forward.warnings) log("warning: " + warning);
    }
    statistics.oneMap = passes == 1 && forward.photonsEmitted > 0;
  };

  const PixelBounds& bounds = film.bounds();
  const int tilesX = (bounds.width() + TILE - 1) / TILE, tilesY = (bounds.height() + TILE - 1) / TILE;
  const size_t tiles = size_t(tilesX) * size_t(tilesY);
  // Every pass needs a sample.
  const int64_t wanted =
      settings.samplesPerPixel > 0 ? std::max(settings.samplesPerPixel, passes) : int64_t(1) << 31;
  // As in pbrt: a sample stands for its share of the pixel, of which many samples leave at least an eighth.
  const float sampleSpacing =
      settings.samplesPerPixel > 0 ? std::max(0.125f, 1 / std::sqrt(static_cast<float>(wanted))) : 1;
  Clock::time_point pictureStart = start;
  std::vector<TransportCounts> tileCounts(tiles);
  const int64_t first = settings.firstSample, last = settings.endSample > 0 ? settings.endSample : wanted;
  SampleAllocation* const allocation = settings.allocation;
  if (allocation) allocation->setMapPerSample(passes == 0 || passes == wanted);
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
    teller.error = statistics.error = error;
    errorTime = seconds(errorLooked - pictureStart);
    errorReached = settings.errorTarget > 0 && error <= settings.errorTarget;
  };

  int64_t sample = std::max(first, settings.from.sample), pass = 0;
  const auto passEnd = [&] { return passes == 0 ? pass + 1 : (pass + 1) * wanted / passes; };
  while (passEnd() <= sample && sample < last) ++pass;

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

  if (samplesBefore > 0) lookAtError(true);
  bool ready = false; // has the photons of `pass`
  while (sample < last && !stop && !timeUp && !errorReached) {
    if (!ready || sample == passEnd()) {
      if (ready) ++pass;
      // A pass that would not be ready in time is not begun: too few photons are worth nothing.
      if (shots > 0 && settings.timeLimit > 0 &&
          seconds(Clock::now() - start) + forwardSeconds / shots > settings.timeLimit)
        break;
      if (!ready && pass > 0) shootPass(0); // which the later ones look back at
      shootPass(uint32_t(pass));
      if (stop) break;
      // From the second pass on the photons' progress is a part of the picture's.
      control.progress = [](double) {};
      if (!ready) pictureStart = Clock::now();
      ready = true;
    }
    const int64_t round = std::clamp<int64_t>(sample - first, 1, LARGEST_ROUND);
    const int64_t stageEnd = allocation ? std::min(SampleAllocation::stageEnd(sample), last) : last;
    if (allocation) allocation->begin(sample, stageEnd, settings.seed, film);
    const int64_t end = std::min({passEnd(), sample + round, stageEnd});
    // How many samples of a pixel there are to be at the end of the round.
    const auto due = [&](size_t pixel) {
      return allocation ? allocation->due(pixel, end) : uint64_t(end - first);
    };
    const int64_t pilots = allocation ? allocation->pilots(sample, end) : 0;
    std::atomic<size_t> tilesDone{0};
    parallelFor(tiles, [&](size_t tile) {
      if (stop || timeUp || saveDue) return;
      const int x0 = int(tile % size_t(tilesX)) * TILE, y0 = int(tile / size_t(tilesX)) * TILE;
      const int x1 = std::min(x0 + TILE, bounds.width()), y1 = std::min(y0 + TILE, bounds.height());
      TransportCounts counts;
      EyeBatch batch(scene, integrator, classes, counts, film, allocation);
      uint64_t taken = 0;
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
          const size_t pixel = size_t(y) * size_t(bounds.width()) + size_t(x);
          // Keyed by the place on the whole film, so that a crop is a part of the same picture.
          const uint64_t stream = uint64_t(uint32_t(y + bounds.y0)) << 32 | uint32_t(x + bounds.x0);
          const Vec2f corner(float(x + bounds.x0), float(y + bounds.y0));
          // None is left where the tile was done before the round was interrupted.
          const uint64_t before = film.samples(pixel), after = std::max(before, due(pixel));
          for (uint64_t n = before; n < after; ++n)
            batch.add(settings.seed, stream, static_cast<uint32_t>(uint64_t(first) + n), pixel, corner,
                      sampleSpacing, n - before < uint64_t(pilots));
          taken += after - before;
        }
      batch.flush();
      ++tilesDone;
      if (taken == 0) return;
      tileCounts[tile].add(counts);
      const uint64_t samples = samplesDone += taken;
      const uint64_t rays = raysDone += counts.rays;
      const double elapsed = seconds(Clock::now() - start), inPicture = seconds(Clock::now() - pictureStart);
      // The first round is always finished: every pixel gets a sample.
      if (settings.timeLimit > 0 && sample > first && elapsed > settings.timeLimit) timeUp = true;
      if (settings.save && seconds(Clock::now() - saved) > settings.saveInterval) saveDue = true;
      const double perPixel = double(samples) / double(bounds.area());
      double left = INFINITY;
      if (settings.samplesPerPixel > 0) {
        const double all = double(last - first) * double(bounds.area());
        left = inPicture * (all - double(samples)) / double(samples - samplesBefore);
      }
      if (settings.errorTarget > 0 && teller.error > 0) // the error falls as one over the root of time
        left = std::min(left, errorTime * square(teller.error / settings.errorTarget) - inPicture);
      if (settings.timeLimit > 0) left = std::min(left, settings.timeLimit - elapsed);
      left = std::max(left, 0.0);
      teller.say("picture", inPicture / (inPicture + left), left, perPixel, double(rays) / inPicture);
    });
    if (settings.timeLimit > 0 && seconds(Clock::now() - start) > settings.timeLimit) timeUp = true;
    if (tilesDone == tiles) {
      sample = end;
      ++statistics.passes;
      lookAtError(settings.errorTarget > 0 && passes == 1);
    }
    if (saveDue) save();
  }
  lookAtError(true);
  if (settings.save) save();

  for (const TransportCounts& c : tileCounts) statistics.counts.add(c);
  statistics.samples = film.totalSamples();
  std::vector<uint64_t> counts(bounds.area());
  for (size_t i = 0; i < counts.size(); ++i) counts[i] = film.samples(i);
  const auto middle = counts.begin() + std::ptrdiff_t((counts.size() - 1) / 2);
  std::nth_element(counts.begin(), middle, counts.end());
  statistics.median = *middle;
  const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
  statistics.least = *least;
  statistics.most = *most;
  statistics.renderSeconds = seconds(Clock::now() - start);
  statistics.processorSeconds = processorSeconds() - processorStart;
  statistics.gatherSeconds = statistics.renderSeconds - statistics.photonSeconds - statistics.balanceSeconds;
  if (stop)
    statistics.stopReason = StopReason::INTERRUPTED;
  else if (errorReached)
    statistics.stopReason = StopReason::ERROR;
  else if (sample < last)
    statistics.stopReason = StopReason::TIME;
  teller.say("picture", 1, 0, double(statistics.samples) / double(bounds.area()),
             double(raysDone) / std::max(statistics.gatherSeconds, 1e-9), true);
  return statistics;
}

} // namespace recurse
