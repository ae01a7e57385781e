/** @file
 * Errors of irradiance estimates with kernel supports of several areas at a point, estimated from the photons
 * of one pass.
 */
#pragma once

#include <algorithm>
#include <array>

#include "transport/density/boundaryCorrection.h"
#include "transport/density/gather.h"
#include "transport/direct/lightSampler.h"

namespace recurse {

/** Model of camera rays that replace photons. */
struct RayAlternative {
  float emitted = 0;                    ///< number of photons emitted in the pass
  const LightSampler* lights = nullptr; ///< for shadow rays; null: rays do not share light with photons
  /** Maximum of a ray's estimate over the irradiance at the point: larger ones are too rare to count. */
  float maxBrightness = 100;
};

/** Scale of detail of the light that a map's photons represent. */
enum class LightDetail {
  SMOOTH,
  /** Caustics: detail finer than any support of several photons. Supports blur it alike, so that comparing
   * them reveals no bias. */
  FINE
};

/**
 * Errors of estimates with supports of several areas at a point, from the photons of one pass. The variance
 * is the sum of squared contributions of the photons. Two supports whose estimates differ by more than chance
 * reveal bias, as in Lepski's choice of a bandwidth ("On a problem of adaptive estimation in Gaussian white
 * noise", 1990). The areas double from one to the next.
 */
struct SupportErrors {
  static constexpr size_t AREAS = 8, OWN = 3; ///< OWN: index of the record's own area
  std::array<double, AREAS> variance{};       ///< variance due to the number of photons
  std::array<double, AREAS> bias2{}; ///< squared difference to the next support's estimate, less its noise
  std::array<double, AREAS> noise{}; ///< variance of that difference
  std::array<double, AREAS> rays2{}; ///< second moment of the same estimate by a continuing ray
  double direct = 0;                 ///< irradiance by shadow rays
  double irradiance = 0;             ///< irradiance by the support OWN

  void add(const SupportErrors& e, double scale) {
    for (size_t j = 0; j < AREAS; ++j) {
      variance[j] += e.variance[j] * scale;
      bias2[j] += e.bias2[j] * scale;
      noise[j] += e.noise[j] * scale;
      rays2[j] += e.rays2[j] * scale;
    }
    irradiance += e.irradiance * scale;
    direct += e.direct * scale;
  }
  /** Squared bias between a support and the next that chance does not explain. */
  double sureBias2(size_t j) const {
    constexpr double CHANCE = 0.7; // squared spread of such a difference over a few neighbouring records
    return std::max(0.0, bias2[j] - CHANCE * noise[j]);
  }
  /** Index of the area with the least variance + biasWeight · bias² + squared difference to the next area,
   * with bias relative to OWN. Bias is proportional to area and areas double: this difference is a support's
   * own bias. */
  size_t best(double biasWeight, LightDetail detail) const {
    constexpr double SURE = 0.5; // choosing fewer photons requires better evidence than more
    size_t best = OWN;
    double least = double(INFINITE), below = 0;
    const auto error = [&](size_t j) { return variance[j] + biasWeight * below + sureBias2(j); };
    const size_t widest = detail == LightDetail::FINE ? OWN + 1 : AREAS - 2;
    for (size_t j = OWN; j <= widest; ++j) {
      if (const double e = error(j); e < least) {
        least = e;
        best = j;
      }
      // At an edge the bias grows less than it does elsewhere, but it remains.
      below += sureBias2(j);
    }
    below = 0;
    least *= SURE;
    for (size_t j = 0; j < OWN; ++j)
      if (const double e = error(j); e < least) {
        least = e;
        best = j;
      }
    return best;
  }
};

/** Errors accumulated over several records. */
struct Evidence {
  SupportErrors relative, absolute; ///< relative errors, for the choice; absolute [W²/m⁴]
  double squared = 0;               ///< sum of squared irradiances
  int recordCount = 0;

  /** `dark2`: added to the squared irradiance by which errors are divided. */
  void add(const SupportErrors& e, double dark2) {
    if (!(e.irradiance > 0)) return;
    relative.add(e, 1 / (square(e.irradiance) + dark2));
    absolute.add(e, 1);
    squared += square(e.irradiance);
    ++recordCount;
  }
  /** Mean relative variance of a record's own support. */
  double relativeVariance() const { return absolute.variance[SupportErrors::OWN] / squared; }
};

/** Radius of the support with area index j, over the radius of the record. */
inline float ofArea(size_t j) {
  return std::exp2(0.5f * (static_cast<float>(j) - static_cast<float>(SupportErrors::OWN)));
}

/** Errors from the photons in a map, without shadow rays. `region`: with the record's own radius; `error`:
 * bound of the error of its centre. */
SupportErrors supportErrors(const PhotonMap& photons, GatherRegion region, Kernel kernel, float error,
                            BoundaryCorrection& boundary, const RayAlternative& byRays,
                            TransportCounts& counts);

} // namespace recurse
