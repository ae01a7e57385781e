/** @file
 * The forward pass: photons from the lights into a list, in the order of emission.
 */
#pragma once

#include <vector>

#include "recurse/transport/emissionGuide.h"
#include "recurse/transport/integrator.h"
#include "recurse/transport/photon.h"

namespace recurse {

struct ShootSettings {
  uint64_t photons = 0; ///< emitted
  int maxDepth =
      -1; ///< most scattering events of a photon, the one where it is stored included; -1: no limit
  bool direct = true;                   ///< store photons that come straight from a light as well
  const EmissionGuide* guide = nullptr; ///< where photons are worth most; null: everywhere
};

struct ShotPhotons {
  std::vector<Photon> stored; ///< powers are divided by the number emitted
  uint64_t emitted = 0;
  TransportCounts counts;
};

/**
 * Lights are chosen by power; at each surface a photon is stored where there is a diffuse lobe, and goes on
 * by roulette on what the surface scatters, so that powers stay nearly equal. The list is the same for any
 * number of threads. Photons that no path class can use are not followed.
 */
ShotPhotons shootPhotons(const Scene& scene, const PathClasses& classes, const Pass& pass,
                         const ShootSettings& settings, const ForwardControl& control);

/**
 * Learns from trial photons where those start that come down in the region: as few as will do, where most do
 * so anyway, and the guide is then not active. `counts` gets what the trials cost.
 */
EmissionGuide learnEmission(const Scene& scene, const PathClasses& classes, uint64_t seed,
                            const ShootSettings& settings, const VisibleRegion& region,
                            const ForwardControl& control, TransportCounts& counts);

} // namespace recurse
