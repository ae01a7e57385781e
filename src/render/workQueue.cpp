/** @file
 * Division of a render into units of work.
 */
#include "recurse/render/workQueue.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace recurse {

namespace {

/** Units per worker into which the remaining work is divided, so that the last units are short. */
constexpr double UNITS_LEFT = 3;
/** Longest pass that is one unit [wanted unit sizes]. A longer one is divided, and its photons are shot again
 * for each part. */
constexpr double LONG_PASS = 4;

} // namespace

WorkQueue::WorkQueue(int64_t samples, int64_t tiles, const Passes& passes)
    : WorkQueue(samples, tiles, passes, {WorkUnit{0, samples, 0, tiles}}) {}

WorkQueue::WorkQueue(int64_t samples, int64_t tiles, const Passes& passes, std::vector<WorkUnit> left)
    : samples(samples), tiles(tiles), passes(passes) {
  for (const WorkUnit& unit : left) giveBack(unit);
}

double WorkQueue::size() const {
  double out = 0;
  for (const WorkUnit& unit : units) out += unit.size();
  return out;
}

std::pair<int64_t, int64_t> WorkQueue::extent(double wanted, int workers) const {
  const WorkUnit& front = units.front();
  const int64_t width = front.endTile - front.firstTile;
  const bool hasOneMap = passes.schedule() == PassSchedule::ONE_MAP;
  if (hasOneMap && wholePasses) {
    const int64_t count = front.endSample - front.firstSample;
    return {count, std::clamp<int64_t>(int64_t(wanted / double(count)), 1, width)};
  }
  if (hasOneMap) {
    const auto count = int64_t(wanted / double(width));
    return count > 0 ? std::pair(count, width) : std::pair(int64_t(1), std::max<int64_t>(1, int64_t(wanted)));
  }
  int64_t pass = passOf(front.firstSample);
  const int64_t passesLeft = passOf(units.back().endSample - 1) - pass + 1;
  // With fewer passes than workers, several workers shoot the same photons and share the tiles.
  const int64_t sharers = passesLeft >= workers ? 1 : (workers + passesLeft - 1) / passesLeft;
  const int64_t share = sharers == 1 ? width : std::min(width, (tiles + sharers - 1) / sharers);
  // Whole passes as many as fit, or a part of a pass with very many samples.
  int64_t end = passBegin(pass + 1);
  const int64_t inPass = std::min(end, front.endSample) - front.firstSample;
  if (wholePasses && double(inPass) * double(share) > LONG_PASS * wanted)
    return {inPass, std::max<int64_t>(1, int64_t(LONG_PASS * wanted / double(inPass)))};
  if (double(end - front.firstSample) * double(share) > LONG_PASS * wanted)
    return {std::max<int64_t>(1, int64_t(LONG_PASS * wanted / double(share))), share};
  while (end < front.endSample && double(passBegin(pass + 2) - front.firstSample) * double(share) <= wanted)
    end = passBegin(++pass + 1);
  return {end - front.firstSample, share};
}

double WorkQueue::smallest(int workers) const {
  if (units.empty()) return 0;
  const auto [count, width] = extent(1, workers);
  return double(count) * double(width);
}

std::optional<WorkUnit> WorkQueue::take(double wanted, int workers) {
  if (units.empty()) return {};
  const auto [count, width] = extent(std::min(wanted, size() / (UNITS_LEFT * double(workers))), workers);
  WorkUnit& front = units.front();
  WorkUnit unit = front;
  unit.endSample = std::min(front.endSample, front.firstSample + count);
  unit.endTile = std::min(front.endTile, front.firstTile + width);
  WorkUnit right = unit, below = front;
  right.firstTile = unit.endTile;
  right.endTile = front.endTile;
  right.includesSplats = false; // splats belong to the first tile
  below.firstSample = unit.endSample;
  units.erase(units.begin());
  giveBack(right);
  giveBack(below);
  return unit;
}

void WorkQueue::giveBack(const WorkUnit& unit) {
  if (!(unit.endSample > unit.firstSample && unit.endTile > unit.firstTile)) return;
  const auto key = [](const WorkUnit& u) { return std::tuple(u.firstSample, u.firstTile); };
  units.insert(std::upper_bound(units.begin(), units.end(), unit,
                                [&](const WorkUnit& a, const WorkUnit& b) { return key(a) < key(b); }),
               unit);
}

} // namespace recurse
