/** @file
 * Queue of work units of a render, shared by several processes.
 */
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "recurse/transport/integrator/passes.h"

namespace recurse {

/** Samples [firstSample, endSample) of the pixels of tiles [firstTile, endTile). */
struct WorkUnit {
  int64_t firstSample = 0, endSample = 0;
  int64_t firstTile = 0, endTile = 0;
  bool includesSplats = true; ///< renders the splats of the passes that begin here

  /** Number of tile samples: samples times tiles. */
  double size() const { return double(endSample - firstSample) * double(endTile - firstTile); }
};

/** Work that is not yet assigned. Units are taken from its beginning, so that samples are rendered roughly in
 * order. */
class WorkQueue {
 public:
  /** Queue of all samples [0, samples) of each pixel of the tiles [0, tiles). */
  WorkQueue(int64_t samples, int64_t tiles, const Passes& passes);
  /** Queue of the remaining work of a render. */
  WorkQueue(int64_t samples, int64_t tiles, const Passes& passes, std::vector<WorkUnit> left);
  /** Makes units contain all queued samples of a pass for their tiles. */
  void keepPassesWhole() { wholePasses = true; }

  bool empty() const { return units.empty(); }
  const std::vector<WorkUnit>& left() const { return units; }
  /** Total WorkUnit::size() of the queue. */
  double size() const;
  /** The first sample of the next unit; the queue must not be empty. */
  int64_t nextSample() const { return units.front().firstSample; }

  /**
   * Takes a unit for one of `workers` processes, of about `size` [tile samples]: whole passes where there are
   * many, which may be longer, since their photons serve all tiles; otherwise samples and tiles. Empty: no
   * work is left. Units become small towards the end, so that all processes end at the same time.
   */
  std::optional<WorkUnit> take(double size, int workers);
  /** Approximate size of the smallest unit that take() would return [tile samples]; 0 for an empty queue. */
  double smallest(int workers) const;
  /** Returns unfinished work to the queue. */
  void giveBack(const WorkUnit& unit);

 private:
  int64_t passBegin(int64_t pass) const { return passes.begin(pass, samples); }
  int64_t passOf(int64_t sample) const { return passes.of(sample, samples); }
  /** Samples and tiles of a unit for a requested size. */
  std::pair<int64_t, int64_t> extent(double size, int workers) const;

  int64_t samples, tiles;
  Passes passes;
  bool wholePasses = false;
  std::vector<WorkUnit> units; ///< sorted by first sample, then by tile
};

} // namespace recurse
