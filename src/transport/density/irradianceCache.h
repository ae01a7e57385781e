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
  void reset(size_t placeCount) {
    if (placeCount != count) places = std::make_unique<Place[]>(count = placeCount);
    for (size_t i = 0; i < count; ++i) places[i].set(Rgb(NAN));
  }
  /** Irradiance at a record, [W/m²]: result of find(counts) on first use. Thread-safe: several threads may
   * compute it at once, with equal results; it is counted once. */
  template <class Find> Rgb at(size_t place, TransportCounts& counts, const Find& find) const {
    const Rgb known = places[place].get();
    if (!std::isnan(known.r + known.g + known.b)) return known;
    TransportCounts own;
    const Rgb found = find(own);
    if (places[place].set(found)) counts.add(own);
    return found;
  }
  size_t size() const { return count; }

 private:
  /** Cached value, complete when no component is NaN: a thread may see components in any order. */
  struct Place {
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
  std::unique_ptr<Place[]> places;
  size_t count = 0;
};

} // namespace recurse
