/** @file
 * The render loop.
 */
#include "recurse/transport/render.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <ctime>
#include <mutex>
#include <numeric>
#include <thread>

#include "recurse/core/inPlace.h"
#include "recurse/core/parallel.h"
#include "recurse/core/text.h"
#include "recurse/scene/spectrum.h"

namespace recurse {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int TILE = 16;
/** Samples of one round at the most: a round is the unit in which all pixels are equal. */
constexpr int LARGEST_ROUND = 64;
/** Tells the times of passes from other samples. */
constexpr uint64_t TIME_STREAM = 0x54494d4553ull;

/**
 * The unit of splats: 2^-28 of the radiance that the lights' flux would give if it left the scene's bounding
 * sphere evenly. 2^35 times that is the largest sum: of 10,000 passes a mean of three million.
 */
double splatUnit(const Scene& scene) {
  double flux = 0;
  for (size_t i = 0; i < scene.lights().size(); ++i) flux += double(maxComponent(scene.lights()[i].power()));
  const double even = flux / square(2 * M_PI * double(scene.bounds().radius));
  return std::isnormal(even) ? std::exp2(std::ilogb(even) - 28) : 0x1p-28;
}

double seconds(Clock::duration d) { return std::chrono::duration<double>(d).count(); }
/** What the threads of the process have worked so far. */
double processorSeconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

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

/** What the samples of a round share. */
struct Round {
  uint64_t seed;
  float sampleSpacing;
  std::optional<float> time; ///< of all camera rays; none: each draws its own
};

/** Looks at the clock, and whether the render is to stop, while samples are under way that may take long. */
class Watchdog {
 public:
  explicit Watchdog(std::function<void()> look)
      : look(std::move(look)), thread([this](std::stop_token done) { watch(done); }) {}

 private:
  void watch(const std::stop_token& done) {
    std::mutex own;
    std::unique_lock<std::mutex> lock(own);
    std::condition_variable_any sleep;
    while (!done.stop_requested()) {
      look();
      sleep.wait_for(lock, done, std::chrono::milliseconds(20), [] { return false; });
    }
  }
  std::function<void()> look;
  std::jthread thread;
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

/** What the film makes of a sample before it counts. */
void expose(const FilmSettings& film, PathRadiance& sample) {
  if (film.maxComponent < INFINITE) {
    const Vec3d xyz = xyzOfRgb(Rgbd(sample.total())) * double(film.imagingRatio);
    const double largest = std::max({xyz.x, xyz.y, xyz.z});
    if (largest > double(film.maxComponent))
      sample.scale(static_cast<float>(double(film.maxComponent) / largest));
  }
  if (film.whiteBalance) sample.transform([&](const Rgb& c) { return *film.whiteBalance * c; });
}

/** Collects eye paths, has them walked together, and puts what they bring into the film in the same order. */
class EyeBatch {
 public:
  EyeBatch(const Scene& scene, const Integrator& integrator, const PathClasses& classes,
           TransportCounts& counts, const Round& round, Film& film, Splatter* splatter,
           SampleAllocation* allocation, const std::atomic<bool>* abandon)
      : scene(scene), integrator(integrator), round(round), film(film), allocation(allocation),
        usesLens(scene.camera().usesLens()), nothing(classes, counts),
        radiance(CAMERA_BATCH, PathRadiance(classes, counts)) {
    paths.reserve(CAMERA_BATCH);
    for (PathRadiance& r : radiance) {
      r.splatter = splatter;
      r.abandon = abandon;
    }
  }
  /** Sample `index` of a pixel, whose upper left corner is at `corner` on the film. `pilot`: the allocation
   * is told of it. */
  void add(uint64_t stream, uint32_t index, size_t pixel, const Vec2f& corner, bool pilot) {
    if (abandoned) return;
    Place& place = places[count++];
    CameraPath& path = paths.emplace_back(Sampler(round.seed, stream, index), radiance[paths.size()]);
    const Filter::Sample f = scene.filter().sample(path.sampler.next2D());
    CameraSample sample{corner + 0.5f + f.offset};
    if (usesLens) sample.lens = path.sampler.next2D();
    sample.time = round.time ? *round.time : scene.camera().timeAt(path.sampler.next1D());
    const std::optional<CameraRay> ray = scene.camera().validRay(sample);
    path.out->reset();
    place.pixel = pixel;
    place.weight = f.weight;
    place.pilot = pilot;
    place.seesNothing = !ray;
    if (ray) {
      path.ray = *ray;
      path.ray.sampleSpacing = round.sampleSpacing;
    } else {
      paths.pop_back();
    }
    if (count == CAMERA_BATCH) flush();
  }
  void flush() {
    if (!paths.empty()) integrator.backwardBatch(scene, paths);
    abandoned = abandoned || radiance[0].abandoned();
    for (size_t i = 0, path = 0; i < count && !abandoned; ++i) {
      const Place& place = places[i];
      PathRadiance& seen = place.seesNothing ? nothing : radiance[path];
      if (!place.seesNothing && paths[path].ray.weight != 1) seen.scale(paths[path].ray.weight);
      path += !place.seesNothing;
      expose(scene.film(), seen);
      film.add(place.pixel, place.weight, seen.values(), seen.total());
      if (place.pilot) allocation->addPilot(place.pixel, double(luminance(seen.total())));
      ++samplesTaken;
    }
    paths.clear();
    count = 0;
  }
  /** How many samples have reached the film. */
  uint64_t taken() const { return samplesTaken; }
  /** True when samples were broken off: none of them, and none after, has reached the film. */
  bool isAbandoned() const { return abandoned; }

 private:
  struct Place {
    size_t pixel;
    float weight;
    bool pilot, seesNothing;
  };
  const Scene& scene;
  const Integrator& integrator;
  const Round& round;
  Film& film;
  SampleAllocation* allocation;
  bool usesLens;
  PathRadiance nothing; ///< stays black
  std::vector<PathRadiance> radiance;
  std::vector<CameraPath> paths; ///< of the places that see something
  std::array<Place, CAMERA_BATCH> places;
  size_t count = 0; ///< of places
  uint64_t samplesTaken = 0;
  bool abandoned = false;
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
  ProgressReporter reporter(progress, start);
  RenderStatistics statistics = settings.from.statistics;
  statistics.threads = threadCount();
  integrator.prepare(scene, classes);

  ForwardControl control;
  control.stop = &stop;
  control.progress = [&](double fraction) {
    const double elapsed = seconds(Clock::now() - start);
    reporter.say("photons", fraction, fraction > 0.02 ? elapsed / fraction - elapsed : -1, 0, 0);
  };
  const int passes = integrator.passes(settings.samplesPerPixel);
  double forwardSeconds = 0; ///< of the `shots` that were made here
  int shots = 0;
  // Splats of a pass that is broken off do not reach the film: it is shot again when the render goes on.
  std::optional<SplatPlane> passSplats;
  std::optional<Splatter> passSplatter, sampleSplatter;
  if (integrator.splats()) {
    film.enableSplats(splatUnit(scene));
    passSplats.emplace(film.bounds(), film.layerCount(), film.splats()->unit());
    passSplatter.emplace(classes, scene.filter(), *passSplats);
    sampleSplatter.emplace(classes, scene.filter(), *film.splats());
    passSplatter->whiteBalance = sampleSplatter->whiteBalance = scene.film().whiteBalance;
  }
  const bool moves = scene.moves();
  const auto timeOf = [&](uint32_t pass) {
    return scene.camera().timeAt(moves ? Sampler(settings.seed, TIME_STREAM, pass).next1D() : 0);
  };
  if (moves && integrator.passHasOneTime() && passes == 1) {
    statistics.warnings.emplace_back(
        "one photon map is of one moment: nothing is blurred by its motion; more "
        "passes (\"integer passes\") are of as many");
    if (log) log("warning: " + statistics.warnings.back());
  }
  const auto shootPass = [&](uint32_t index, bool splats) {
    const Clock::time_point passStart = Clock::now();
    control.splatter = splats && passSplatter ? &*passSplatter : nullptr;
    const ForwardStatistics forward =
        integrator.forward(scene, classes, {settings.seed, index, passes == 1, timeOf(index)}, control);
    if (control.splatter && !stop) {
      film.splats()->add(*passSplats);
      film.splats()->setNextPass(index + uint64_t(1));
      passSplats->clear();
    }
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
    reporter.error = statistics.error = error;
    errorTime = seconds(errorLooked - pictureStart);
    errorReached = settings.errorTarget > 0 && error <= settings.errorTarget;
  };

  int64_t sample = std::max(first, settings.from.sample), pass = 0;
  const auto passEnd = [&] { return passes == 0 ? pass + 1 : (pass + 1) * wanted / passes; };
  const auto passStart = [&] { return passes == 0 ? pass : pass * wanted / passes; };
  while (passEnd() <= sample && sample < last) ++pass;
  // Of parts that share a pass one has its splats; but none is without any.
  const auto isSplatted = [&] {
    return film.splats() && (film.splats()->nextPass() > uint64_t(pass) ||
                             (film.splats()->paths() > 0 && sample != passStart()));
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

  std::atomic<bool> abandon{false};
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
    if (!ready || sample == passEnd()) {
      if (ready) ++pass;
      // A pass that would not be ready in time is not begun: too few photons are worth nothing.
      if (shots > 0 && settings.timeLimit > 0 &&
          seconds(Clock::now() - start) + forwardSeconds / shots > settings.timeLimit)
        break;
      if (!ready && pass > 0) shootPass(0, false); // which the later ones look back at
      shootPass(uint32_t(pass), !isSplatted());
      if (stop) break;
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
    if (allocation) allocation->begin(sample, stageEnd, settings.seed, film);
    const int64_t end = std::min({passEnd(), sample + round, stageEnd});
    // How many samples of a pixel there are to be at the end of the round.
    const auto due = [&](size_t pixel) {
      return allocation ? allocation->due(pixel, end) : uint64_t(end - first);
    };
    Round shared{settings.seed, sampleSpacing, {}};
    if (!moves || integrator.passHasOneTime()) shared.time = timeOf(uint32_t(pass));
    std::atomic<size_t> tilesDone{0};
    parallelFor(tiles, [&](size_t number) {
      if (stop || timeUp || saveDue || lookDue) return;
      const size_t tile = settings.timeLimit > 0 ? scattered[number] : number;
      const int x0 = int(tile % size_t(tilesX)) * TILE, y0 = int(tile / size_t(tilesX)) * TILE;
      const int x1 = std::min(x0 + TILE, bounds.width()), y1 = std::min(y0 + TILE, bounds.height());
      TransportCounts counts;
      EyeBatch batch(scene, integrator, classes, counts, shared, film,
                     sampleSplatter ? &*sampleSplatter : nullptr, allocation,
                     sampleSplatter ? nullptr : &abandon); // splats cannot be taken back
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
          const size_t pixel = size_t(y) * size_t(bounds.width()) + size_t(x);
          // Keyed by the place on the whole film, so that a crop is a part of the same picture.
          const uint64_t stream = uint64_t(uint32_t(y + bounds.y0)) << 32 | uint32_t(x + bounds.x0);
          const Vec2f corner(float(x + bounds.x0), float(y + bounds.y0));
          // None is left where the tile was done before the round was interrupted.
          const uint64_t before = film.samples(pixel), after = std::max(before, due(pixel));
          const uint64_t pilots = allocation ? allocation->pilotsLeft(pixel, end) : 0;
          for (uint64_t n = before; n < after; ++n)
            batch.add(stream, static_cast<uint32_t>(uint64_t(first) + n), pixel, corner, n - before < pilots);
        }
      batch.flush();
      if (!batch.isAbandoned()) ++tilesDone;
      const uint64_t taken = batch.taken();
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
      lookAtError(settings.errorTarget > 0 && passes == 1);
    }
    if (saveDue) save();
    if (lookDue) look();
  }
  lookAtError(true);
  if (settings.save) save();

  statistics.oneMap = passes == 1 && statistics.photonsEmitted > 0;
  for (const TransportCounts& c : tileCounts) statistics.counts.add(c);
  if (film.splats()) statistics.splatsSaturated = film.splats()->saturated();
  statistics.samples = film.totalSamples();
  std::vector<uint64_t> counts(bounds.area());
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
    if (log) log("warning: " + statistics.warnings.back());
  }
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

} // namespace recurse
