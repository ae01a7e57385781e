/** @file
 * Where the map of indirect light is read, and where the path goes on instead. A map's noise and blur are
 * shared by neighbouring pixels, those of a path are not; which errs less differs from place to place.
 */
#pragma once

#include <functional>

#include "recurse/transport/radiusCache.h"

namespace recurse {

/** The share of the indirect light at each record of a radius cache that its photons bring; the rest is for a
 * path that goes on. Both estimate the same, so that any shares are right, and these are those of least
 * error. */
class GatherShare {
 public:
  /** Irradiance at a record from one random direction, its channels added up [W/m²], without light that comes
   * straight from lights or by mirrors and glass alone: any number of different samplers may be used from any
   * thread. */
  using SampleIrradiance = std::function<float(const RadiusCache::Place&, Sampler&, TransportCounts&)>;

  /** Everything is read from the map. */
  void readAll() { shares.clear(); }
  /** Compares the spread of a few paths around each record with that of the photons. */
  void learn(const RadiusCache& cache, const SampleIrradiance& sample, TransportCounts& counts);
  /** In [0, 1]. */
  float at(const CachedRadius& place) const {
    if (shares.empty()) return 1;
    return place.known ? shares[place.index] : 0;
  }

 private:
  std::vector<float> shares;
};

} // namespace recurse
