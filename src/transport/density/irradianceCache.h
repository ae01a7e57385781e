/** @file
 * Irradiance from a photon map at the places of a search field, each found out when it is first asked for.
 * The many rays of a final gather read it instead of adding up photons each time (Christensen 1999, "Faster
 * Photon Map Global Illumination", who finds it at photons beforehand).
 */
#pragma once

#include <atomic>
#include <cmath>
#include <memory>

#include "transport/paths/walk.h"

namespace recurse {

class IrradianceCache {
 public:
  /** Forgets everything, and makes room. */
  void reset(size_t placeCount) {
    if (placeCount != count) places = std::make_unique<Place[]>(count = placeCount);
    for (size_t i = 0; i < count; ++i) places[i].set(Rgb(NAN));
  }
  /** What find(counts) returns for the place, [W/m²]. From any thread: several may find it at once, and must
   * then find the same; it is counted once. */
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
  /** A thread may see some of the parts before the others: it is known when none is NaN. */
  struct Place {
    std::atomic<float> r, g, b;
    Rgb get() const {
      constexpr auto order = std::memory_order_relaxed;
      return {r.load(order), g.load(order), b.load(order)};
    }
    /** Whether nobody had set it before. */
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
