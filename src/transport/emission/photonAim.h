/** @file
 * Where lamps that stand far from what is seen send their photons: towards boxes around what camera paths
 * meet, each as the cone that its bounding sphere is seen in, rather than all around, where hardly a photon
 * would meet anything. The density of any direction is known, so that nothing becomes biased.
 */
#pragma once

#include <vector>

#include "recurse/core/math/cone.h"
#include "recurse/transport/integrator/integrator.h"
#include "transport/direct/nestedBoxes.h"

namespace recurse {

class PhotonAim {
 public:
  /** Follows camera paths; finds the lamps whose photons would meet what those meet many times as often. */
  void learn(const Scene& scene, uint64_t seed, TransportCounts& counts);
  /** Some lamps are aimed. */
  bool active() const { return !part.empty(); }
  bool isAimed(uint32_t light) const { return active() && part[light] < 1; }
  size_t lampCount() const;
  /** About what part of a light's power goes where photons are aimed at; 1 for lights that are not aimed. */
  float powerPart(uint32_t light) const { return active() ? part[light] : 1; }

  /** Gives the sample of an aimed light another direction and the flux that goes with it: none where the
   * light does not shine there. `pick` and `u` are numbers in [0, 1) that the sample does not depend on. */
  void redirect(const Light& light, LeSample& sample, float pick, const Vec2f& u) const;
  /** Density of such directions [1/sr]; `own`: that of the light. */
  float pdfDirection(const Light& light, const LeRay& ray, float own) const;

 private:
  Cone coneTo(const NestedBoxes::Box& box, const Vec3f& from) const;
  /** Of the directions through the boxes. `met`: a box whose cone the direction is known to be in, whatever
   * rounding says. */
  float pdfThroughBoxes(const Light& light, const LeRay& ray, const NestedBoxes::Box* met) const;

  NestedBoxes boxes;
  std::vector<float> part; ///< by light
};

} // namespace recurse
