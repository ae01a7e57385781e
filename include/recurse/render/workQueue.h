/** @file
 * The work of a render in units, for processes that share it.
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
  int64_t splats = 1; ///< with the splats of the light paths of the passes that begin here

  /** Samples of a tile, in all. */
  double size() const { return double(endSample - firstSample) * double(endTile - firstTile); }
};

/** What has not been dealt out. Units are cut off its beginning, so that samples come about in their order.
 */
class WorkQueue {
 public:
  /** For samples of each pixel. */
  WorkQueue(int64_t samples, int64_t tiles, const Passes& passes);
  /** The same with what is left of a render. */
  WorkQueue(int64_t samples, int64_t tiles, const Passes& passes, std::vector<WorkUnit> left);
  /** Units keep all samples of a pass that their tiles have in the queue. */
  void keepPassesWhole() { wholePasses = true; }

  bool empty() const { return units.empty(); }
  const std::vector<WorkUnit>& left() const { return units; }
  /** Of the units left: WorkUnit::size. */
  double size() const;
  /** The first sample of the next unit; the queue must not be empty. */
  int64_t nextSample() const { return units.front().firstSample; }

  /**
   * A unit for one of `workers` processes, of about `size` or less: whole passes where there are many, for
   * their photons serve all tiles; samples and tiles else. Towards the end units become small, so that all
   * end at the same time.
   */
  std::optional<WorkUnit> take(double size, int workers);
  /** About the size of the smallest unit that take() would give. */
  double smallest(int workers) const;
  /** Puts back what was not done. */
  void giveBack(const WorkUnit& unit);

 private:
  int64_t passBegin(int64_t pass) const { return passes.begin(pass, samples); }
  int64_t passOf(int64_t sample) const { return passes.of(sample, samples); }
  /** Samples and tiles of the unit for a wanted size. */
  std::pair<int64_t, int64_t> extent(double size, int workers) const;

  int64_t samples, tiles;
  Passes passes;
  bool wholePasses = false;
  std::vector<WorkUnit> units; ///< by first sample and tile
};

} // namespace recurse
