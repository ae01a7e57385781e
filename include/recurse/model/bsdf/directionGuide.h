/** @file
 * Density over directions, which is mixed with BSDF sampling.
 */
#pragma once

#include <cstdint>

#include "recurse/core/math/vector.h"

namespace recurse {

/** Density over directions at a point, independent of the BSDF. */
class DirectionGuide {
 public:
  virtual ~DirectionGuide() = default;

  /** Density of a unit direction [1/sr]; may be zero anywhere if the BSDF is sampled too. */
  virtual float pdf(const Vec3f& direction) const = 0;
  /** Samples a unit direction by u in [0, 1)², and sets `density` to its pdf(). */
  virtual Vec3f sample(Vec2f u, float& density) const = 0;
  /** Probability of sampling the BSDF, in [0, 1). */
  virtual float bsdfProbability() const = 0;

  /** Density of a unit direction by the mixture of this guide and of sampling that has the density `byBsdf`
   * there [1/sr]. */
  float mixturePdf(float byBsdf, const Vec3f& direction) const {
    const float a = bsdfProbability();
    return a * byBsdf + (1 - a) * pdf(direction);
  }
};

/** Directions of incident light that a render has learned for a point and its neighbourhood. */
struct LearnedDirections {
  const DirectionGuide* guide = nullptr; ///< density, valid until the next pass; null: too few records
  bool isSampled = false;                ///< camera paths sample it
  uint64_t records = 0;                  ///< number from which the density was learned
};

/** State of path guiding. */
struct GuideStatistics {
  uint64_t cells = 0;   ///< regions with records
  uint64_t cellsOn = 0; ///< number of these with a density that camera paths sample
  uint64_t records = 0; ///< photons and vertices of training paths from which all cells were learned
  /** Second moment of camera paths without a guide over that with the guide before the latest training:
   * geometric mean over rows of the film. Without a guide a path that has the density p with it and q without
   * it occurs q / p times as often, with p / q times the luminance. */
  double gain = 1;

  double fractionOn() const { return cells > 0 ? double(cellsOn) / double(cells) : 0; }
  bool operator==(const GuideStatistics&) const = default;
};

} // namespace recurse
