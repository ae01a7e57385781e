/** @file
 * Steps of a render: photons of a pass, and samples of a tile of the picture, in any order that the caller
 * chooses.
 */
#pragma once

#include <algorithm>
#include <functional>
#include <optional>

#include "recurse/model/film/film.h"
#include "recurse/render/renderSettings.h"

namespace recurse {

class SampleRenderer {
 public:
  /** Samples [first, end) of a pixel. The first of them are the pilots [firstPilot, endPilot) of the
   * allocation's stage. */
  struct PixelSamples {
    uint64_t first = 0, end = 0, firstPilot = 0, endPilot = 0;
  };
  struct TileResult {
    uint64_t samples = 0;
    bool abandoned = false; ///< some samples are missing
  };

  /** Prepares the integrator. Uses samplesPerPixel, seed and allocation. All arguments must outlive it. */
  SampleRenderer(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                 const RenderSettings& settings, Film& film,
                 const std::function<void(const std::string&)>& log);
  SampleRenderer(const SampleRenderer&) = delete;
  SampleRenderer& operator=(const SampleRenderer&) = delete;

  /** Samples of each pixel: at least samplesPerPixel, or 2^31 where a different limit ends the render. */
  int64_t samples() const { return wanted; }
  const Passes& passes() const { return allPasses; }
  /** True if one pass serves all samples. */
  bool hasOneMap() const { return allPasses.schedule() == PassSchedule::ONE_MAP; }
  /** True if each sample has photons of its own. */
  bool hasMapPerSample() const {
    return allPasses.schedule() == PassSchedule::PER_SAMPLE || allPasses.minSamples() == wanted;
  }
  int64_t passBegin(int64_t pass) const { return allPasses.begin(pass, wanted); }
  int64_t passEnd(int64_t pass) const { return passBegin(pass + 1); }
  /** Index of the pass of a sample. */
  int64_t passOf(int64_t sample) const { return allPasses.of(sample, wanted); }

  /** Shoots the photons of a pass, which the following samples use. Pass 0 has to be shot before any later
   * one. `splats`: contributions of its light paths are added to the film. False if stopped: then nothing of
   * the pass is kept. */
  bool shootPass(int64_t pass, bool splats, ForwardControl& control);

  /** Side of a square tile [pixels]; tiles at the border may be smaller. */
  static constexpr int TILE = 16;
  size_t tiles() const { return size_t(tilesX) * size_t(tilesY); }
  /** Calls use(pixel, x, y) for the pixels of a tile, row by row; x and y count from the film's bounds. */
  template <class Use> void forEachPixel(size_t tile, const Use& use) const {
    const PixelBounds& bounds = film.bounds();
    const int x0 = int(tile % size_t(tilesX)) * TILE, y0 = int(tile / size_t(tilesX)) * TILE;
    const int x1 = std::min(x0 + TILE, bounds.width()), y1 = std::min(y0 + TILE, bounds.height());
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) use(size_t(y) * size_t(bounds.width()) + size_t(x), x, y);
  }
  /** Renders samples of the latest pass into the film, for each pixel in the range `samplesOf(pixel)`.
   * Callable from any thread, for different tiles. `abandon`: stops the rendering when it becomes true. */
  TileResult renderTile(size_t tile, const std::function<PixelSamples(size_t pixel)>& samplesOf,
                        TransportCounts& counts, const std::atomic<bool>* abandon);

  /** Renders samples [first, end) of the pixel at (x, y) on the whole film, which must be within the bounds,
   * and records their paths. Returns the counts. Callable from any thread, for different recorders. */
  TransportCounts recordSamples(int x, int y, uint64_t first, uint64_t end, PathRecorder& recorder) const {
    return renderSamples(x, y, first, end, &recorder);
  }
  /** Does the same without a change of the film. */
  void recordAside(int x, int y, uint64_t first, uint64_t end, PathRecorder& recorder) const;
  /** Renders these samples into the film and returns the counts; `recorder` may be null. */
  TransportCounts renderSamples(int x, int y, uint64_t first, uint64_t end, PathRecorder* recorder) const;

  /** Statistics up to now of everything except samples: times, photons, notes, warnings. */
  RenderStatistics statistics;

 private:
  const Scene& scene;
  Integrator& integrator;
  const PathClasses& classes;
  const RenderSettings& settings;
  Film& film;
  std::function<void(const std::string&)> log;
  Passes allPasses;
  int64_t wanted;
  uint32_t requestedSamples; ///< samples of each pixel as planned
  float sampleSpacing;
  bool moves;
  int tilesX, tilesY;
  int64_t pass = 0;
  // Splats of an abandoned pass do not reach the film: the pass is shot again when the render resumes.
  std::optional<SplatPlane> passSplats;
  std::optional<Splatter> passSplatter;

  float timeOf(int64_t pass) const;
  TransportCounts renderInto(Film& to, int x, int y, uint64_t first, uint64_t end,
                             PathRecorder* recorder) const;
};

} // namespace recurse
