/** @file
 * What a render consists of: photons of a pass, and samples of a tile of the picture, which whoever deals
 * them out may ask for in any order.
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
  /** Samples [first, end) of a pixel. At the beginning are pilots [firstPilot, endPilot) of the allocation's
   * stage. */
  struct PixelSamples {
    uint64_t first = 0, end = 0, firstPilot = 0, endPilot = 0;
  };
  struct TileResult {
    uint64_t samples = 0;
    bool abandoned = false; ///< some samples are missing
  };

  /** Prepares the integrator. Of the settings: samplesPerPixel, seed, allocation. All must outlive it. */
  SampleRenderer(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                 const RenderSettings& settings, Film& film,
                 const std::function<void(const std::string&)>& log);
  SampleRenderer(const SampleRenderer&) = delete;
  SampleRenderer& operator=(const SampleRenderer&) = delete;

  /** Of each pixel: samplesPerPixel, or so many that other limits come first. */
  int64_t samples() const { return wanted; }
  const Passes& passes() const { return allPasses; }
  /** One pass serves all samples. */
  bool hasOneMap() const { return allPasses.schedule() == PassSchedule::ONE_MAP; }
  /** Each sample has photons of its own. */
  bool hasMapPerSample() const {
    return allPasses.schedule() == PassSchedule::PER_SAMPLE || allPasses.minSamples() == wanted;
  }
  int64_t passBegin(int64_t pass) const { return allPasses.begin(pass, wanted); }
  int64_t passEnd(int64_t pass) const { return passBegin(pass + 1); }
  /** The pass that a sample belongs to. */
  int64_t passOf(int64_t sample) const { return allPasses.of(sample, wanted); }

  /** Shoots the photons of a pass, which the samples are of from now on. The first pass has to have been shot
   * before any other. `splats`: what its light paths bring goes to the film. False where it was
   * stopped: nothing of it counts. */
  bool shootPass(int64_t pass, bool splats, ForwardControl& control);

  /** A square of so many pixels, fewer at the border. */
  static constexpr int TILE = 16;
  size_t tiles() const { return size_t(tilesX) * size_t(tilesY); }
  /** Calls use(pixel, x, y) for the pixels of a tile, row by row; x and y are those on the film's bounds. */
  template <class Use> void forEachPixel(size_t tile, const Use& use) const {
    const PixelBounds& bounds = film.bounds();
    const int x0 = int(tile % size_t(tilesX)) * TILE, y0 = int(tile / size_t(tilesX)) * TILE;
    const int x1 = std::min(x0 + TILE, bounds.width()), y1 = std::min(y0 + TILE, bounds.height());
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) use(size_t(y) * size_t(bounds.width()) + size_t(x), x, y);
  }
  /** Renders samples of the pass whose photons were shot last into the film; of a pixel as many as
   * `samplesOf(pixel)` says. Any thread, for different tiles. `abandon`: breaks off when it becomes true. */
  TileResult renderTile(size_t tile, const std::function<PixelSamples(size_t pixel)>& samplesOf,
                        TransportCounts& counts, const std::atomic<bool>* abandon);

  /** The same for samples [first, end) of the pixel at (x, y) of the whole film, which is within its bounds.
   * Their paths are recorded. */
  void recordSamples(int x, int y, uint64_t first, uint64_t end, PathRecorder& recorder);

  /** So far, of what is not of samples: times, photons, notes, warnings. */
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
  float sampleSpacing;
  bool moves;
  int tilesX, tilesY;
  int64_t pass = 0;
  // Splats of a pass that is broken off do not reach the film: it is shot again when the render goes on.
  std::optional<SplatPlane> passSplats;
  std::optional<Splatter> passSplatter;

  float timeOf(int64_t pass) const;
};

} // namespace recurse
