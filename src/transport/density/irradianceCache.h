/** @file
 * Cache of irradiance from a photon map at the records of a radius cache, each computed on first use. The
 * many rays of a final gather look it up instead of gathering photons each time (Christensen 1999, "Faster
 * Photon Map Global Illumination", who precomputes it at photons).
 */
#pragma once

#include <atomic>
#include <cmath>
#include <memory>

#include "transport/paths/walk.h"

namespace recurse {

class IrradianceCache {
 public:
  /** Clears the cache and resizes it. */
  void reset(size_t recordCount) {
    if (recordCount != count) records = std::make_unique<Record[]>(count = recordCount);
    for (size_t i = 0; i < count; ++i) records[i].set(Rgb(NAN));
  }
  /** Irradiance at a record, [W/m²]: result of find(counts) on first use. Thread-safe: several threads may
   * compute it at once, with equal results; it is counted once. */
  template <class Find> Rgb at(size_t record, TransportCounts& counts, const Find& find) const {
    const Rgb known = records[record].get();
    if (!std::isnan(known.r + known.g + known.b)) return known;
    TransportCounts spent;
    const Rgb found = find(spent);
    if (records[record].set(found)) counts.add(spent);
    return found;
  }
  size_t size() const { return count; }

 private:
  /** Cached value, complete when no component is NaN: a thread may see components in any order. */
  struct Record {
    std::atomic<float> r, g, b;
    Rgb get() const {
      constexpr auto order = std::memory_order_relaxed;
      return {r.load(order), g.load(order), b.load(order)};
    }
    /** Stores a value. Returns whether it was the first. */
    bool set(const Rgb& c) {
      constexpr auto order = std::memory_order_relaxed;
      g.store(c.g, order);
      b.store(c.b, order);
      return std::isnan(r.exchange(c.r, order));
    }
  };
  std::unique_ptr<Record[]> records;
  size_t count = 0;
};

} // namespace recurse
