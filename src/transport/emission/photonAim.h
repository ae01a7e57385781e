/** @file
 * Directions of photons from lights so far from the visible surfaces that hardly any photon would hit them.
 * They are sampled in cones around the bounding spheres of boxes, which enclose the vertices of camera paths.
 * The density of each direction is known, so that the estimate remains unbiased.
 */
#pragma once

#include <vector>

#include "recurse/core/math/cone.h"
#include "recurse/transport/integrator/integrator.h"
#include "transport/direct/nestedBoxes.h"

namespace recurse {

class PhotonAim {
 public:
  /** Follows camera paths. Aims finite lights whose photons then hit the vertices over 8 times as often. */
  void learn(const Scene& scene, uint64_t seed, TransportCounts& counts);
  /** Whether any light is aimed. */
  bool active() const { return !powerParts.empty(); }
  bool isAimed(uint32_t light) const { return active() && powerParts[light] < 1; }
  size_t lampCount() const;
  /** Estimated fraction of a light's power that is emitted towards the boxes; 1 for lights without an aim. */
  float powerPart(uint32_t light) const { return active() ? powerParts[light] : 1; }

  /** Replaces the direction and flux of an aimed light's sample. The flux is black where the light does not
   * emit in that direction. `pick` and `u` are in [0, 1) and independent of the sample. */
  void redirect(const Light& light, LeSample& sample, float pick, const Vec2f& u) const;
  /** Density of redirect()'s directions [1/sr]; `unaimed`: density of the light's directions [1/sr]. */
  float pdfDirection(const Light& light, const LeRay& ray, float unaimed) const;

 private:
  Cone coneTo(const NestedBoxes::Box& box, const Vec3f& from) const;
  /** Density of directions towards the boxes [1/sr]. `met`: a box whose cone contains the direction, even if
   * rounding errors deny it; may be null. */
  float pdfThroughBoxes(const Light& light, const LeRay& ray, const NestedBoxes::Box* met) const;

  NestedBoxes boxes;
  std::vector<float> powerParts; ///< powerPart() by light; empty: no light is aimed
};

} // namespace recurse
