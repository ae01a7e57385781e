/** @file
 * Rendering of the photons of a pass and the samples of a tile.
 */
#include "render/sampleRenderer.h"

#include <algorithm>
#include <chrono>

#include "recurse/core/io/text.h"
#include "recurse/core/threads/interrupt.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/core/threads/processorTime.h"
#include "recurse/core/threads/resources.h"
#include "recurse/scene/parameters/spectrum.h"

namespace recurse {

namespace {

using Clock = std::chrono::steady_clock;

/** Sampler stream of the times of passes. */
constexpr uint64_t TIME_STREAM = 0x54494d4553ull;

/**
 * Unit of splats: 2^-28 of the radiance that the lights' flux would give if it left the scene's bounding
 * sphere uniformly. Contributions to a pixel that sees a small part of the scene may be 2^60 times that.
 */
double splatUnit(const Scene& scene) {
  double flux = 0;
  for (size_t i = 0; i < scene.lights().size(); ++i) flux += double(maxComponent(scene.lights()[i].power()));
  const double even = flux / square(2 * M_PI * double(scene.bounds().radius));
  return std::isnormal(even) ? std::exp2(std::ilogb(even) - 28) : 0x1p-28;
}

/** Constants of all samples in a round. */
struct Round {
  uint64_t seed;
  uint32_t requestedSamples; ///< samples of each pixel as planned
  float sampleSpacing;
  std::optional<float> time; ///< time of all camera rays; none: each draws its own
};

/** Applies the film's clamp and white balance to a sample. */
void expose(const FilmSettings& film, PathRadiance& sample) {
  if (film.maxComponent < INFINITE) {
    const Vec3d xyz = xyzOfRgb(Rgbd(sample.total())) * double(film.imagingRatio);
    const double largest = std::max({xyz.x, xyz.y, xyz.z});
    if (largest > double(film.maxComponent))
      sample.scale(static_cast<float>(double(film.maxComponent) / largest));
  }
  if (film.whiteBalance) sample.transform([&](const Rgb& c) { return *film.whiteBalance * c; });
}

/** Batch of up to `capacity` camera paths: the integrator walks them together, and their radiance is added to
 * the film in the order of add(). */
class EyeBatch {
 public:
  EyeBatch(const Scene& scene, const Integrator& integrator, const PathClasses& classes,
           TransportCounts& counts, const Round& round, Film& film, size_t capacity,
           SampleAllocation* allocation, const std::atomic<bool>* abandon, PathRecorder* recorder = nullptr)
      : scene(scene), integrator(integrator), round(round), film(film), allocation(allocation),
        recorder(recorder), usesLens(scene.camera().usesLens()), nothing(classes, counts),
        radiance(capacity, PathRadiance(classes, counts)), places(capacity) {
    paths.reserve(capacity);
    for (PathRadiance& r : radiance) {
      r.abandon = abandon;
      r.recorder = recorder;
    }
  }
  /** Adds sample `index` of the pixel with its upper left corner at (x, y) on the whole film. `pilot`: number
   * of a pilot sample, whose luminance goes to the allocation. */
  void add(int x, int y, uint32_t index, size_t pixel, std::optional<size_t> pilot) {
    if (abandoned) return;
    Place& place = places[count++];
    const PixelSample numbered{round.seed, static_cast<uint32_t>(x), static_cast<uint32_t>(y), index,
                               round.requestedSamples};
    CameraPath& path = paths.emplace_back(scene.sampler(), numbered, radiance[paths.size()]);
    const Filter::Sample f = scene.filter().sample(path.sampler.next2D());
    CameraSample sample{Vec2f(x, y) + 0.5f + f.offset};
    if (usesLens) sample.lens = path.sampler.next2D();
    sample.time = round.time ? *round.time : scene.camera().timeAt(path.sampler.next1D());
    const std::optional<CameraRay> ray = scene.camera().validRay(sample);
    path.out->reset();
    place.pixel = pixel;
    place.index = index;
    place.weight = f.weight;
    place.pilot = pilot;
    place.seesNothing = !ray;
    if (ray) {
      path.ray = *ray;
      path.ray.sampleSpacing = round.sampleSpacing;
    } else {
      paths.pop_back();
    }
    if (recorder) {
      RecordedSample recorded{.index = index, .film = sample.film, .filterWeight = f.weight};
      recorded.rayWeight = ray ? ray->weight : 0;
      if (ray) recorded.origin = ray->origin, recorded.direction = ray->direction;
      recorder->beginSample(recorded);
    }
    if (count == places.size() || recorder) flush();
  }
  void flush() {
    walk();
    for (size_t i = 0, path = 0; i < count && !abandoned; ++i) {
      const Place& place = places[i];
      PathRadiance& seen = place.seesNothing ? nothing : radiance[path];
      if (!place.seesNothing && paths[path].ray.weight != 1) seen.scale(paths[path].ray.weight);
      path += !place.seesNothing;
      expose(scene.film(), seen);
      if (recorder) recorder->endSample(seen.total());
      film.add(place.pixel, place.index, place.weight, seen.values().data(), seen.total());
      if (place.pilot) allocation->addPilot(place.pixel, *place.pilot, luminance(seen.total()));
      ++samplesTaken;
    }
    paths.clear();
    count = 0;
  }
  /** Number of samples that have reached the film. */
  uint64_t taken() const { return samplesTaken; }
  /** True after samples were abandoned: neither they nor any later ones have reached the film. */
  bool isAbandoned() const { return abandoned; }

 private:
  /** Traces what has been collected, ray by ray until the samples are broken off. */
  void walk() {
    if (paths.empty()) return;
    const std::atomic<bool>* const abandon = radiance[0].abandon;
    try {
      const InterruptibleWork rays(abandon ? abandon : InterruptibleWork::flag());
      integrator.backwardBatch(scene, paths);
    } catch (const Interrupted&) {
      if (!abandon) throw;
    }
    abandoned = abandoned || radiance[0].abandoned();
  }

  struct Place {
    size_t pixel = 0;
    uint32_t index = 0;
    float weight = 0;
    std::optional<size_t> pilot;
    bool seesNothing = false;
  };
  const Scene& scene;
  const Integrator& integrator;
  const Round& round;
  Film& film;
  SampleAllocation* allocation;
  PathRecorder* recorder; ///< null: nothing is recorded; else each sample is walked alone
  bool usesLens;
  PathRadiance nothing; ///< stays black
  std::vector<PathRadiance> radiance;
  std::vector<CameraPath> paths; ///< paths of the places with a camera ray
  std::vector<Place> places;
  size_t count = 0; ///< number of places in use
  uint64_t samplesTaken = 0;
  bool abandoned = false;
};

} // namespace

std::string guideText(const GuideStatistics& guide) {
  return formatted("guide: %llu cells, %.0f %% of them sampled, learned from %llu records; squared error of "
                   "paths without over with it: %.3g",
                   static_cast<unsigned long long>(guide.cells), 100 * guide.fractionOn(),
                   static_cast<unsigned long long>(guide.records), guide.gain);
}

SampleRenderer::SampleRenderer(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                               const RenderSettings& settings, Film& film,
                               const std::function<void(const std::string&)>& log)
    : scene(scene), integrator(integrator), classes(classes), settings(settings), film(film), log(log),
      allPasses(integrator.passes(settings.samplesPerPixel)),
      wanted(settings.samplesPerPixel > 0
                 ? std::max(int64_t(settings.samplesPerPixel), allPasses.minSamples())
                 : int64_t(1) << 31),
      // Under a time or error limit, points and textures are for the scene's own number of samples.
      requestedSamples(static_cast<uint32_t>(
          settings.samplesPerPixel > 0 ? wanted : int64_t(scene.sampler().pixelSamples))),
      // Sample spacing: a sample covers its part of the pixel, at least an eighth of its width as in pbrt.
      sampleSpacing(std::max(0.125f, 1 / std::sqrt(static_cast<float>(requestedSamples)))),
      moves(scene.moves()), tilesX((film.bounds().width() + TILE - 1) / TILE),
      tilesY((film.bounds().height() + TILE - 1) / TILE) {
  statistics.threads = threadCount();
  if (settings.allocation) settings.allocation->setMapPerSample(hasMapPerSample());
  if (const std::string unsupported = unsupportedPart(integrator, scene); !unsupported.empty())
    throw Error("the integrator cannot render " + unsupported);
  {
    const ProcessorTimer timer(statistics.learningProcessorSeconds);
    statistics.counts.add(integrator.prepare(scene, classes));
  }
  if (integrator.splats()) {
    requireMemory("the splats of the film", // of all passes unless they are resumed, and of one
                  (film.splats() ? 1 : 2) *
                      SplatPlane::bytes(double(film.bounds().area()), double(film.layerCount())));
    film.enableSplats(splatUnit(scene));
    passSplats.emplace(film.bounds(), film.layerCount(), film.splats()->unit());
    passSplatter.emplace(classes, scene.filter(), *passSplats);
    passSplatter->whiteBalance = scene.film().whiteBalance;
  }
  if (moves && integrator.passHasOneTime() && hasOneMap()) {
    statistics.warnings.emplace_back("a single photon map has one time: photons show no motion blur. More "
                                     "passes (\"integer passes\") sample more times");
    if (log) log("warning: " + statistics.warnings.back());
  }
}

float SampleRenderer::timeOf(int64_t index) const {
  return scene.camera().timeAt(
      moves ? Sampler(settings.seed, TIME_STREAM, static_cast<uint32_t>(index)).next1D() : 0);
}

bool SampleRenderer::shootPass(int64_t index, bool splats, ForwardControl& control) {
  pass = index;
  control.splatter = splats && passSplatter ? &*passSplatter : nullptr;
  ForwardStatistics forward;
  const double processorStart = processorSeconds();
  try {
    // Processes that share photons wait for each other, and must end a pass together.
    const InterruptibleWork shooting(control.sharing ? nullptr : control.stop);
    forward = integrator.forward(
        scene, classes, {settings.seed, static_cast<uint32_t>(index), allPasses.schedule(), timeOf(index)},
        control);
  } catch (const Interrupted&) { // the pass is not complete
  }
  const bool isComplete = !control.stopped();
  if (control.splatter && isComplete) {
    film.splats()->add(*passSplats);
    film.splats()->setNextPass(uint64_t(index) + 1);
  }
  if (control.splatter) passSplats->clear();
  statistics.counts.add(forward.counts);
  statistics.learningProcessorSeconds += forward.learningSeconds;
  statistics.photonProcessorSeconds += processorSeconds() - processorStart - forward.learningSeconds;
  statistics.photonSeconds += forward.shootSeconds;
  statistics.balanceSeconds += forward.balanceSeconds;
  if (!isComplete) return false;
  statistics.mapBytes = std::max(statistics.mapBytes, forward.mapBytes);
  statistics.photonsEmitted += forward.photonsEmitted;
  statistics.photonsStored += forward.photonsStored;
  statistics.photonsRefused += forward.photonsRefused;
  ++statistics.forwardPasses;
  statistics.notes.insert(statistics.notes.end(), forward.notes.begin(), forward.notes.end());
  statistics.warnings.insert(statistics.warnings.end(), forward.warnings.begin(), forward.warnings.end());
  const bool isTrained = forward.guide && forward.guide != statistics.guide;
  if (forward.guide) statistics.guide = forward.guide;
  if (log) {
    if (isTrained) log(guideText(*statistics.guide));
    for (const std::string& note : forward.notes) log(note);
    for (const std::string& warning : forward.warnings) log("warning: " + warning);
  }
  return true;
}

SampleRenderer::TileResult
SampleRenderer::renderTile(size_t tile, const std::function<PixelSamples(size_t pixel)>& samplesOf,
                           TransportCounts& counts, const std::atomic<bool>* abandon) {
  const PixelBounds& bounds = film.bounds();
  Round round{settings.seed, requestedSamples, sampleSpacing, {}};
  if (!moves || integrator.passHasOneTime()) round.time = timeOf(pass);
  EyeBatch batch(scene, integrator, classes, counts, round, film, CAMERA_BATCH, settings.allocation, abandon);
  forEachPixel(tile, [&](size_t pixel, int x, int y) {
    const PixelSamples samples = samplesOf(pixel);
    for (uint64_t n = samples.first; n < samples.end; ++n) {
      const uint64_t pilot = samples.firstPilot + (n - samples.first);
      batch.add(x + bounds.x0, y + bounds.y0, static_cast<uint32_t>(n), pixel,
                pilot < samples.endPilot ? std::optional<size_t>(pilot) : std::nullopt);
    }
  });
  batch.flush();
  return {batch.taken(), batch.isAbandoned()};
}

TransportCounts SampleRenderer::renderSamples(int x, int y, uint64_t first, uint64_t end,
                                              PathRecorder* recorder) const {
  return renderInto(film, x, y, first, end, recorder);
}

void SampleRenderer::recordAside(int x, int y, uint64_t first, uint64_t end, PathRecorder& recorder) const {
  Film aside({x, y, x + 1, y + 1}, classes.layerCount());
  renderInto(aside, x, y, first, end, &recorder);
}

TransportCounts SampleRenderer::renderInto(Film& to, int x, int y, uint64_t first, uint64_t end,
                                           PathRecorder* recorder) const {
  const PixelBounds& bounds = to.bounds();
  Round round{settings.seed, requestedSamples, sampleSpacing, {}};
  if (!moves || integrator.passHasOneTime()) round.time = timeOf(pass);
  TransportCounts counts;
  const size_t capacity = recorder ? 1 : std::min<size_t>(CAMERA_BATCH, end - first);
  EyeBatch batch(scene, integrator, classes, counts, round, to, capacity, nullptr, nullptr, recorder);
  const size_t pixel = size_t(y - bounds.y0) * size_t(bounds.width()) + size_t(x - bounds.x0);
  for (uint64_t n = first; n < end; ++n) batch.add(x, y, static_cast<uint32_t>(n), pixel, std::nullopt);
  batch.flush();
  return counts;
}

} // namespace recurse
