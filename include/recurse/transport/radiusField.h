/** @file
 * How far a progressive density estimate looks, before any shrinking: known at every point, and independent
 * of the photons of the pass that uses it, so that those are counted without bias.
 */
#pragma once

#include "recurse/transport/photonMap.h"

namespace recurse {

/**
 * The radius of a progressive estimate in pass `index` (0, 1, …) over that of the first pass, after Knaus and
 * Zwicker, "Progressive Photon Mapping: A Probabilistic Approach" (2011), equation 15: the squares of
 * successive radii are as (i + alpha) : (i + 1). A pass depends on no other, so any machine may do it. alpha
 * in (0, 1]: 1 never shrinks.
 */
float radiusScale(uint32_t index, double alpha);

class RadiusField {
 public:
  /** Takes at places all over a first photon map the distance to the k-th photon, and at most `limit`. The
   * map is not needed afterwards. */
  void build(const PhotonMap& first, int nearest, float limit);
  /** About where a search for the k-th photon of the first map would have ended: the distance known at the
   * nearest of the places, and no less than the way there. */
  float at(const Vec3f& position) const;
  size_t memoryBytes() const { return places.memoryBytes(); }

 private:
  PhotonMap places; ///< the distance stands in the power
  float limit = 0;
};

} // namespace recurse
