/** @file
 * The forward pass: photons from the lights into a list, in the order of emission.
 */
#pragma once

#include <vector>

#include "recurse/transport/integrator/integrator.h"
#include "transport/forward/shootSettings.h"
#include "transport/media/photonBeams.h"
#include "transport/media/volumePhotons.h"
#include "transport/photonmap/photon.h"

namespace recurse {

struct ShotPhotons {
  std::vector<Photon> stored;        ///< powers are divided by the number emitted
  std::vector<VolumePhoton> inMedia; ///< the same
  std::vector<PhotonBeam> beams;     ///< the same
  uint64_t emitted = 0;
  uint64_t emittedHere = 0; ///< of them by this process, see PhotonSharing
  uint64_t storedHere = 0;  ///< the same, in media too
  TransportCounts counts;   ///< here
};

/**
 * Lights are chosen by power; at each surface a photon is stored where there is a diffuse lobe, and goes on
 * by roulette on what the surface scatters, so that powers stay nearly equal. The list is the same for any
 * number of threads. Photons that no path class can use are not followed.
 */
ShotPhotons shootPhotons(const Scene& scene, const PathClasses& classes, const Pass& pass,
                         const ShootSettings& settings, const ForwardControl& control);

} // namespace recurse
