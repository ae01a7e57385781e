/** @file
 * How estimates of irradiance with kernel supports of several areas err at a place, by the photons of one
 * pass.
 */
#pragma once

#include <algorithm>
#include <array>

#include "transport/density/boundaryCorrection.h"
#include "transport/density/gather.h"
#include "transport/density/rayAlternative.h"

namespace recurse {

/** How fine the light is that a map's photons bring. */
enum class LightDetail {
  SMOOTH,
  /** Caustics: lines finer than any disc of several photons, which discs that are compared with each other
   * blur alike, so that they do not tell. */
  FINE
};

/**
 * How estimates with discs of several areas err at a place, told by the photons of one pass: their variance
 * is the sum of the squares of what each photon brings, and two discs whose estimates differ by more than
 * chance show bias, as in Lepski's choice of a bandwidth ("On a problem of adaptive estimation in Gaussian
 * white noise", 1990). The areas double from one to the next.
 */
struct SupportErrors {
  static constexpr size_t AREAS = 8, OWN = 3; ///< OWN: the area of the place
  std::array<double, AREAS> variance{};       ///< of the photons' number
  std::array<double, AREAS> bias2{}; ///< by how much, squared, the next disc differs beyond what is noise
  std::array<double, AREAS> noise{}; ///< the variance of that difference
  std::array<double, AREAS> rays2{}; ///< second moment of the same estimate by a ray that goes on
  double direct = 0;                 ///< irradiance by shadow rays
  double irradiance = 0;             ///< by the own disc

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
  /** Bias between a disc and the next that chance does not explain. */
  double sureBias2(size_t j) const {
    constexpr double CHANCE = 0.7; // the spread of such a difference, squared, over some neighbouring places
    return std::max(0.0, bias2[j] - CHANCE * noise[j]);
  }
  /** The area with the least variance + biasWeight · bias². The bias of a disc goes with its area, so the
   * next one's is larger by as much as it is itself. */
  size_t best(double biasWeight, LightDetail detail) const {
    constexpr double SURE = 0.5; // to look at fewer photons takes better evidence than to look at more
    size_t best = OWN;
    double least = double(INFINITE), below = 0;
    const auto error = [&](size_t j) { return variance[j] + biasWeight * below + sureBias2(j); };
    const size_t widest = detail == LightDetail::FINE ? OWN + 1 : AREAS - 2;
    for (size_t j = OWN; j <= widest; ++j) {
      if (const double e = error(j); e < least) {
        least = e;
        best = j;
      }
      // Where an edge is met, the bias does not grow as it does elsewhere, but it stays.
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

/** What several places tell together. */
struct Evidence {
  SupportErrors relative, absolute; ///< relative errors, which the choice goes by, and errors [W²/m⁴]
  double squared = 0;               ///< irradiances
  int places = 0;

  /** `dark2`: added to the squared irradiance that an error is relative to. */
  void add(const SupportErrors& e, double dark2) {
    if (!(e.irradiance > 0)) return;
    relative.add(e, 1 / (square(e.irradiance) + dark2));
    absolute.add(e, 1);
    squared += square(e.irradiance);
    ++places;
  }
  /** Of one place's own disc. */
  double relativeVariance() const { return absolute.variance[SupportErrors::OWN] / squared; }
};

/** The radius of a disc over that of the place. */
inline float ofArea(size_t j) {
  return std::exp2(0.5f * (static_cast<float>(j) - static_cast<float>(SupportErrors::OWN)));
}

/** Of light, which variances go by. */
inline float channelSum(const Rgb& c) { return c.r + c.g + c.b; }

/** Of the photons in a map, and of shadow rays nothing. `region`: of the place's own radius; `error` bounds
 * that of its centre. */
SupportErrors supportErrors(const PhotonMap& photons, GatherRegion region, Kernel kernel, float error,
                            BoundaryCorrection& boundary, const RayAlternative& byRays,
                            TransportCounts& counts);

} // namespace recurse
